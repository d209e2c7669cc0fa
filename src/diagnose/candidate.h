/* A candidate cause, and its forward model on the samples of a recording. */
#ifndef MUKCA_DIAGNOSE_CANDIDATE_H
#define MUKCA_DIAGNOSE_CANDIDATE_H

#include "diagnose/recording.h"
#include "effect/catalogue.h"
#include "infer/mixture.h"

/* Highest order per turn of a smooth function of an angle: some six of the narrowest bumps, 0.12
 * rad, make a wave. */
enum { MUKCA_SMOOTH_ORDER = 8 };

#define MUKCA_WAVE_UNIT 0.70710678118654752440 /* rms of a sine */

/* An effect of the catalogue, or a rival explanation of the structure. */
typedef enum {
    MUKCA_CANDIDATE_EFFECT,   /* of the catalogue, but for motions of a socket */
    MUKCA_CANDIDATE_MOTION,   /* of the catalogue: a socket moved */
    MUKCA_CANDIDATE_OUTLIER,  /* one sample displaced, or a few successive ones alike */
    MUKCA_CANDIDATE_UNLISTED, /* a function of an argument: a cause outside the catalogue */
    MUKCA_CANDIDATE_KINDS
} mukca_candidate_kind;

/* What an unlisted cause is a function of. */
typedef enum {
    MUKCA_ARGUMENT_ANGLE,   /* of a joint */
    MUKCA_ARGUMENT_TORQUE,  /* about its axis */
    MUKCA_ARGUMENT_ACROSS,  /* the same with gravity along two axes across the model's: a wall */
    MUKCA_ARGUMENT_PAYLOAD, /* that of the outermost mass, in one placement or in all */
    MUKCA_ARGUMENT_MOMENT,  /* about a joint's or the base's origin, three components */
    MUKCA_ARGUMENT_MOVE,    /* last one of a joint */
    MUKCA_ARGUMENT_TIME,
    MUKCA_ARGUMENT_ROW,
    MUKCA_ARGUMENT_PLACEMENT, /* 1 in one placement, else 0 */
    MUKCA_ARGUMENT_TILT,      /* of an axis of the tip */
    MUKCA_ARGUMENT_NONE
} mukca_argument;

/* Functions of an argument. */
typedef enum {
    MUKCA_SHAPE_LINEAR,
    MUKCA_SHAPE_SPRING,    /* the same of a load, as each part deflects: about a moment's axis */
    MUKCA_SHAPE_SIDE,      /* to which side of 0; of an angle, of the middle of its range */
    MUKCA_SHAPE_WAVE,      /* sine and cosine */
    MUKCA_SHAPE_SOFTENING, /* times time */
    MUKCA_SHAPE_DELAYED,   /* some time ago: elastic after-effect */
    MUKCA_SHAPE_RUBBING,   /* the side times the load: friction */
    MUKCA_SHAPE_WEARING,   /* the side times a decay: changing friction */
    /* of unit size */
    MUKCA_SHAPE_BUMPS,     /* any smooth function */
    MUKCA_SHAPE_POWERS,    /* polynomial */
    MUKCA_SHAPE_PRODUCTS,  /* the same of two angles, the joint's own and another */
    MUKCA_SHAPE_STEP,      /* from a row on */
    MUKCA_SHAPE_SATURATING /* towards a limit */
} mukca_shape;

/* Where an unlisted cause acts. */
typedef enum {
    MUKCA_PLACE_ANGLE,  /* angle of a joint */
    MUKCA_PLACE_ANGLES, /* of all joints, each a function of its own argument */
    MUKCA_PLACE_LINK,   /* rotation of the link before a joint */
    MUKCA_PLACE_SHIFT,  /* of a frame of the geometry */
    MUKCA_PLACE_TURN,
    MUKCA_PLACE_BASE,     /* rotation of the base */
    MUKCA_PLACE_SOCKET,   /* the ball in it */
    MUKCA_PLACE_TOOL,     /* the ball on it */
    MUKCA_PLACE_DISTANCE, /* of a placement's sockets */
    MUKCA_PLACES
} mukca_unlisted_place;

/* Where a candidate acts: a site of effects, or one of these. */
enum {
    MUKCA_SITE_FRAME = MUKCA_SITE_DISTANCE + 1, /* shift or rotation of a frame of the geometry */
    MUKCA_SITE_SEAT                             /* the ball in its socket, with the tool's tilt */
};

/* Displacement of a socket by a fault, over its rows. */
typedef enum {
    MUKCA_FAULT_STEADY,
    MUKCA_FAULT_FADING, /* a badly seated ball settles */
    MUKCA_FAULT_GROWING /* from 0 to 1: the tool creeps */
} mukca_fault_shape;

/* Classes, equals in the competition: the catalogue's effects, then two rivals of all effects. */
enum { MUKCA_CLASS_OUTLIER = MUKCA_EFFECT_COUNT, MUKCA_CLASS_UNKNOWN, MUKCA_CLASSES };

typedef struct {
    mukca_candidate_kind kind;
    int joint, placement; /* that it acts on; -1: none or all */
    bool as_one;          /* elastic: one coefficient for all masses */
    union {
        mukca_effect effect;        /* EFFECT: joint and placement as above */
        struct {                    /* MOTION, OUTLIER */
            int group, first, last; /* rows of the dataset */
            mukca_fault_shape shape;
        } fault;
        struct {          /* UNLISTED */
            int function; /* row of mukca_unlisted_function */
            mukca_unlisted_place place;
            int argument;   /* joint whose angle, load or move; axis of the tip; -1: none */
            int slot;       /* SHIFT, TURN: of the unknowns */
            double measure; /* width of a bump, rad; order of a wave; first row of a step; time
                               constant, s */
        } unlisted;
    };
    int terms, width_of_term; /* width: 1 angle, 3 of a rotation or shift, n_joints angles */
    /* [n_rows][terms][width_of_term]; NULL: sites SOCKET, DISTANCE and SEAT */
    float *basis;
    bool shares_basis; /* and units: those of another candidate */
    double *unit;      /* [terms] rms rotation, rad, per unit of coefficient; shifts: 1 */
    double log_prior;
} mukca_candidate;

/* The candidate of an effect of the catalogue, to be prepared. */
mukca_candidate mukca_candidate_of(const mukca_effect *effect);

/* Class of a candidate: its effect, or one of the two rival classes. */
int mukca_candidate_class(const mukca_candidate *candidate);

/* Is it a fault of one socket or sample, which displaces the socket and not the arm? */
bool mukca_candidate_is_fault(const mukca_candidate *candidate);

/* Does it displace the arm's joints or tip? */
bool mukca_candidate_moves_arm(const mukca_candidate *candidate);

/* Is it fitted with one factor per mass: first a term of all masses, then one term for each? */
bool mukca_candidate_by_mass(const mukca_candidate *candidate);

/* Is it a part that deflects in proportion to its load, or a servo, listed or not? */
bool mukca_candidate_is_flexible(const mukca_candidate *candidate);

/* Terms of the effect itself, without those for errors of the masses. */
int mukca_candidate_own_terms(const mukca_candidate *candidate);

/* The same candidate of a list? */
bool mukca_candidate_same(const mukca_candidate *a, const mukca_candidate *b);

/* Effect of a candidate that is no rival, without coefficients. */
mukca_effect mukca_candidate_effect(const mukca_candidate *candidate);

/* Where it acts. */
int mukca_candidate_site(const mukca_candidate *candidate);

/* Displacement of a fault's socket at a row of the dataset, in units of its coefficients. */
double mukca_candidate_fault_share(const mukca_candidate *candidate,
                                   const mukca_recording *recording, int row);

/* Does a candidate change the distance of that pair of sockets? */
bool mukca_candidate_changes_pair(const mukca_candidate *candidate,
                                  const mukca_recording *recording, int pair);

/* Prior scales of coefficient * unit over which a candidate is averaged, for columns per unit. */
mukca_mixture mukca_candidate_mixture(const mukca_candidate *candidate);

/* Fill terms, basis and units of a candidate; the other members are set.  In two steps: take
 * memory, unless basis and units are those of a candidate in list[n] (from the last one on, until
 * the function changes), and compute them.  False: no memory. */
bool mukca_candidate_take(mukca_candidate *candidate, mukca_pool *pool,
                          const mukca_recording *recording, const mukca_candidate *list, int n);
void mukca_candidate_compute(const mukca_candidate *candidate, const mukca_recording *recording);
bool mukca_candidate_prepare(mukca_candidate *candidate, mukca_pool *pool,
                             const mukca_recording *recording);

/* ---- unlisted causes (unlisted.c) ---- */

/* The table of unlisted causes: each function is tried at these places. */
typedef struct {
    mukca_argument argument;
    mukca_shape shape;
    int values; /* functions; 0: of the number of bumps */
    int places; /* bits 1 << mukca_unlisted_place */
    mukca_varies varies_with;
    enum { MUKCA_OF_ITSELF, MUKCA_OF_OTHERS, MUKCA_OF_ANY } joints; /* of which joint */
} mukca_unlisted_function;

enum { MUKCA_UNLISTED_FUNCTIONS = 28 };
extern const mukca_unlisted_function mukca_unlisted_functions[MUKCA_UNLISTED_FUNCTIONS];

/* Site, terms and components of a term; and the basis. */
int mukca_unlisted_site(const mukca_candidate *candidate);
void mukca_unlisted_set_shape(mukca_candidate *candidate, const mukca_recording *recording);
void mukca_unlisted_fill(const mukca_candidate *candidate, const mukca_recording *recording);

/* Have its values unit size?  Else they are scaled by the samples. */
bool mukca_unlisted_is_normalised(const mukca_candidate *candidate);

/* Recompute the basis of a prepared candidate, for other angles of the same recording. */
void mukca_candidate_fill(const mukca_candidate *candidate, const mukca_recording *recording);

#endif
