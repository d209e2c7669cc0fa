/* A candidate cause, and its forward model on the samples of a recording. */
#ifndef MUKCA_DIAGNOSE_CANDIDATE_H
#define MUKCA_DIAGNOSE_CANDIDATE_H

#include "diagnose/recording.h"
#include "effect/catalogue.h"
#include "infer/mixture.h"

enum {
    MUKCA_MAX_COLUMNS = MUKCA_MOST_TERMS, /* terms of one candidate */
    /* Highest order per turn of a smooth function of an angle: some six of the narrowest bumps,
     * 0.12 rad, make a wave. */
    MUKCA_SMOOTH_ORDER = 8
};

#define MUKCA_WAVE_UNIT 0.70710678118654752440 /* rms of a sine */

/* An effect of the catalogue, or a rival explanation of the structure. */
typedef enum {
    MUKCA_CANDIDATE_EFFECT,        /* of the catalogue, but for motions of a socket */
    MUKCA_CANDIDATE_MOTION,        /* of the catalogue: a socket moved */
    MUKCA_CANDIDATE_OUTLIER,       /* one sample displaced, or a few successive ones alike */
    MUKCA_CANDIDATE_OWN_ANGLE,     /* unknown: joint error, a smooth function of its angle */
    MUKCA_CANDIDATE_OTHER_ANGLE,   /* unknown: ... of another joint's angle */
    MUKCA_CANDIDATE_ANGLE_PRODUCT, /* unknown: ... of both angles together */
    MUKCA_CANDIDATE_TIME,          /* unknown: ... of time */
    MUKCA_CANDIDATE_SLIP,          /* unknown: the joint slips once, before a sample */
    MUKCA_CANDIDATE_STRETCH,       /* unknown: a link's length changes with time */
    /* Unlisted: simple causes outside the catalogue, without a name */
    MUKCA_CANDIDATE_UNLISTED_ANGLE, /* joint error, a function of an argument */
    MUKCA_CANDIDATE_UNLISTED_FRAME, /* shift or rotation of a frame by it */
    MUKCA_CANDIDATE_UNLISTED_BASE,  /* rotation of the base by it */
    MUKCA_CANDIDATE_UNLISTED_TILT,  /* the ball shifts with the tilt of the tool */
    MUKCA_CANDIDATE_UNLISTED_PAIR,  /* the distance of a placement's sockets is wrong */
    MUKCA_CANDIDATE_KINDS
} mukca_candidate_kind;

/* Argument of an unlisted cause. */
typedef enum {
    MUKCA_ARGUMENT_ANGLE,     /* of a joint */
    MUKCA_ARGUMENT_WAVE,      /* its sine and cosine */
    MUKCA_ARGUMENT_HALF,      /* in which half of its travel: elbow up or down */
    MUKCA_ARGUMENT_LOAD,      /* torque about its axis */
    MUKCA_ARGUMENT_SIDE,      /* sign of that torque */
    MUKCA_ARGUMENT_SOFTENING, /* that torque times time */
    MUKCA_ARGUMENT_MOVE,      /* direction of its last move */
    MUKCA_ARGUMENT_LAG,       /* that move, with its length */
    MUKCA_ARGUMENT_RUBBING,   /* its direction times the load: friction */
    MUKCA_ARGUMENT_CREEP,     /* the load some time ago: elastic after-effect */
    MUKCA_ARGUMENT_WEARING,   /* its direction times a decay: changing friction */
    MUKCA_ARGUMENT_TIME,
    MUKCA_ARGUMENT_PAYLOAD,   /* torque of the outermost mass, in one placement or in all */
    MUKCA_ARGUMENT_PLACEMENT, /* 1 in one placement, else 0 */
    MUKCA_ARGUMENT_MOMENT,    /* about a joint's or the base's origin, three components */
    MUKCA_ARGUMENT_TIPPING,   /* the side of each: a base that rocks, a bearing with play */
    MUKCA_ARGUMENT_SEASON     /* a smooth function of time: the stand follows the room */
} mukca_argument;

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
        struct {                     /* all others: what they are a function of */
            mukca_argument argument; /* UNLISTED */
            int joint; /* whose angle, load or move; -1: none; TILT: axis of the tip */
            int slot;  /* site FRAME: of the unknowns */
            int row;   /* SLIP: first row of the dataset after it */
            bool
                turns; /* site FRAME: rotation, else shift; TILT: in the tool, else in the socket */
            double size; /* OWN_ANGLE: width of a bump, rad; STRETCH: time constant, s */
        } of;
    };
    int terms, width_of_term; /* width: 1 angle, 3 of a rotation or shift, n_joints angles */
    /* [n_rows][terms][width_of_term]; NULL: sites SOCKET, DISTANCE and SEAT */
    float *basis;
    const double *unit; /* [terms] rms rotation, rad, per unit of coefficient; shifts: 1 */
    double log_prior;
} mukca_candidate;

/* The candidate of an effect of the catalogue, to be prepared. */
mukca_candidate mukca_candidate_of(const mukca_effect *effect);

/* Class of a candidate: its effect, or one of the two rival classes. */
int mukca_candidate_class(const mukca_candidate *candidate);

/* Is it a fault of one socket or sample, which displaces the socket and not the arm? */
bool mukca_candidate_is_fault(const mukca_candidate *candidate);

/* Is it an unlisted cause? */
bool mukca_candidate_is_unlisted(const mukca_candidate *candidate);

/* Does it displace the arm's joints or tip? */
bool mukca_candidate_moves_arm(const mukca_candidate *candidate);

/* Is it fitted with one factor per mass: first a term of all masses, then one term for each? */
bool mukca_candidate_by_mass(const mukca_candidate *candidate);

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

/* Prior scales of coefficient * unit over which a candidate is averaged, with the logarithms of
 * their weights; returns their number, at most MUKCA_MAX_SIZES. */
int mukca_candidate_scales(double *scale, double *log_weight, const mukca_candidate *candidate);

/* The same as a mixture, for columns per unit. */
mukca_mixture mukca_candidate_mixture(const mukca_candidate *candidate);

/* Key of the candidates of which a set contains one at most: variants of one cause. */
int mukca_candidate_key(const mukca_candidate *candidate);

/* Fill terms, basis and units of a candidate; the other members are set.  False: no memory. */
bool mukca_candidate_prepare(mukca_candidate *candidate, mukca_pool *pool,
                             const mukca_recording *recording);

/* Of unlisted candidates (unlisted.c): number of terms, basis, and columns out[3][ld], 3 wide, of a
 * TILT for the frame R[9] of the tip. */
int mukca_unlisted_terms(const mukca_candidate *candidate);
void mukca_unlisted_fill(const mukca_candidate *candidate, const mukca_recording *recording);
void mukca_unlisted_tilt(double *out, int ld, const mukca_candidate *candidate, const double *R,
                         const double gravity[3]);

/* Recompute the basis of a prepared candidate, for other angles of the same recording. */
void mukca_candidate_fill(const mukca_candidate *candidate, const mukca_recording *recording);

#endif
