/* The fleet: summaries of arms of one model, grouped by arm, and what they have in common. */
#ifndef MUKCA_FLEET_FLEET_H
#define MUKCA_FLEET_FLEET_H

#include <stdint.h>

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* ---- summary of a recording ----
 *
 * Its information on the coefficients shared by arms of one model, with the geometry of this arm
 * marginalised.  The coefficients are all elastic ones of the chain. */

enum {
    /* Compliance of each joint, link bending before each but the first, and the compliance of the
     * base, which precedes the first. */
    MUKCA_FLEET_TERMS = 2 * MUKCA_MAX_JOINTS,
    MUKCA_FLEET_ORDERS = MUKCA_LAST_ORDER - 1, /* 2 .. 400 */
    MUKCA_FLEET_PACKED = MUKCA_FLEET_TERMS * (MUKCA_FLEET_TERMS + 1) / 2
};

/* Unit of the log Bayes factors of orders, which makes sums exact in any order; clipped at
 * +-2047. */
#define MUKCA_FLEET_QUANTUM (1.0 / 16)

/* Number of coefficients, and the i-th (without value). */
int mukca_fleet_terms(int n_joints);
mukca_effect mukca_fleet_term(int i, int n_joints);

/* The effect at a joint whose order arms share (without order). */
mukca_effect mukca_fleet_wave(int joint);

/* Properties common to arms of one model.  The tool is excluded: all elements after the last joint,
 * and the tip. */
typedef struct {
    char robot[MUKCA_NAME_SIZE], base[MUKCA_NAME_SIZE], tip[MUKCA_NAME_SIZE];
    int n_joints;
    char joint[MUKCA_MAX_JOINTS][MUKCA_NAME_SIZE];
    uint64_t geometry; /* hash of the nominal origins and axes, to a micrometre and a microradian */
    uint64_t masses;   /* hash of the link masses and their positions, to a gram and a micrometre */
} mukca_fleet_model;

typedef struct {
    const char *path; /* its file, for messages; NULL: not from a file */
    mukca_fleet_model model;
    char arm[MUKCA_NAME_SIZE];
    uint64_t data; /* hash of the recording */
    int samples;
    double sigma_m; /* noise */
    /* Of the coefficients: information, lower triangle by rows, (N m/rad)^2; information times
     * estimate. */
    double information[MUKCA_FLEET_PACKED], vector[MUKCA_FLEET_TERMS];
    int16_t ripple[MUKCA_MAX_JOINTS][MUKCA_FLEET_ORDERS]; /* log Bayes factors, in quanta */
} mukca_summary;

static inline int mukca_fleet_packed(int n_terms)
{
    return n_terms * (n_terms + 1) / 2;
}

/* Properties of an arm that must agree within a fleet. */
void mukca_fleet_model_of(mukca_fleet_model *model, const mukca_chain *chain);

/* Reason why summaries of the two models cannot be pooled; NULL: they can. */
const char *mukca_fleet_model_differs(const mukca_fleet_model *a, const mukca_fleet_model *b);

/* Summary of a recording from the regression of its diagnosis, which is fitted with the elastic
 * coefficients in place of elastic causes and then restored.  The caller sets arm and data. Errors:
 * MUKCA_MEMORY, MUKCA_UNIDENTIFIABLE (no fit). */
mukca_status mukca_summary_take(mukca_summary *summary, mukca_regression *m, mukca_error *error);

/* Hash of a recording: its angles, sockets and measured positions. */
uint64_t mukca_summary_hash(const mukca_dataset *data);

/* ---- the fleet ---- */

/* A coefficient or (gear_harmonic) an order of ripple that arms share, whose phase differs between
 * them. */
typedef struct {
    mukca_effect effect;
    /* rad/(N m).  With all coefficients present, the prior of one more arm: mean of the arms, its
     * standard error, standard deviation between arms.  Given that it is not 0, averaged over sets
     * of the others: value and 95 % interval.  Of an order the mean 0, the rest NaN. */
    double mean, error, spread, value, low, high;
    int arms; /* that have information on it, or whose data favour the order */
    /* Of a coefficient above 0, given the other shared ones; of an order, the sum over the arms
     * that do not depart. */
    double log_bayes_factor;
    double probability; /* that the arms share it: against 0; other, individual or no orders */
} mukca_trait;

/* Least probability for it to be called shared; for an arm to be called departing. */
#define MUKCA_SHARED 0.5
#define MUKCA_DEPARTS 0.95

/* The population of a fleet's coefficients: those of each arm, scattered about a common mean.
 *
 * Random effects with known information per arm (N. Laird, J. Ware, Random-effects models for
 * longitudinal data, Biometrics 38, 1982): c_arm ~ N(mean, diag(spread^2)), mean >= 0. */
typedef struct {
    int n; /* coefficients on which at least one arm has information */
    int term[MUKCA_FLEET_TERMS];
    int n_arms;
    mukca_trait trait[MUKCA_FLEET_TERMS];
    /* Of the means: information, including the arms' scatter, and information times estimate. */
    double information[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS], vector[MUKCA_FLEET_TERMS];
    /* Non-negative means and their covariance, averaged over the sets of nonzero ones. */
    double average[MUKCA_FLEET_TERMS], average_covariance[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS];
    double scratch[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS];
} mukca_population;

/* A coefficient of an arm, from its data, compared with its sisters. */
typedef struct {
    int arm, k; /* k: index into the population's coefficients; -1: none is testable */
    mukca_effect effect;
    double value, low, high; /* of the arm, rad/(N m), 95 % */
    double mean;             /* of its sisters */
    double ratio;            /* value / mean; infinite if the mean is 0 */
    double log_bayes_factor; /* of a departure against the scatter of its sisters */
    double probability;      /* corrected for the numbers of arms and coefficients */
} mukca_departure;

enum { MUKCA_MAX_TRAITS = MUKCA_FLEET_TERMS + MUKCA_MAX_JOINTS };

/* The traits of a robot model: results of its fleet, as prior for one more arm. */
typedef struct {
    mukca_fleet_model model;
    int n, n_arms, n_sessions, n_samples;
    mukca_trait list[MUKCA_MAX_TRAITS];
} mukca_traits;

/* One arm: the sum of its sessions, and its comparison with its sisters. */
typedef struct {
    const char *name;
    int first, end; /* its sessions */
    int samples;
    bool departs;                 /* excluded from the population */
    double *information, *vector; /* [packed], [terms] */
    mukca_departure departure;    /* its most deviant coefficient */
    mukca_departure *estimate;    /* [population.n] */
} mukca_fleet_arm;

typedef struct {
    mukca_fleet_model model; /* of the first summary */
    int n_terms, n_sessions, n_arms;
    mukca_summary **session; /* with n_joints rows of ripple only */
    mukca_fleet_arm *arm;    /* set by mukca_fleet_gather */
    /* set by mukca_fleet_pool */
    mukca_population population;
    mukca_trait order[MUKCA_MAX_JOINTS]; /* [n_joints]: the most probable; 0: none was scanned */
    mukca_departure *ranked;             /* [n_arms] the most probable first */
    mukca_traits traits;                 /* [population.n] coefficients, then the shared orders */
    mukca_pool pool;
} mukca_fleet;

/* Add a copy of a summary, whose path must outlive the fleet.  Errors: MUKCA_INPUT (another model,
 * no possible information), MUKCA_MEMORY. */
mukca_status mukca_fleet_take(mukca_fleet *fleet, const mukca_summary *summary, mukca_error *error);

/* Sort the sessions, to make results independent of the order of the files, and sum those of each
 * arm.  Errors: MUKCA_INPUT (the same recording twice), MUKCA_MEMORY. */
mukca_status mukca_fleet_gather(mukca_fleet *fleet, mukca_error *error);

/* Pool a gathered fleet.  Arms that depart are marked and excluded from its population.  Errors:
 * MUKCA_INPUT (fewer than two arms), MUKCA_MEMORY. */
mukca_status mukca_fleet_pool(mukca_fleet *fleet, mukca_error *error);

void mukca_fleet_free(mukca_fleet *fleet);

/* Find the population of the coefficients, the departing arms, which are excluded from it, and the
 * coefficients of all arms.  False: no memory. */
bool mukca_population_fit(mukca_fleet *fleet);

/* Find the most probable order of ripple of each joint: fleet->order. */
void mukca_orders_pool(mukca_fleet *fleet);

/* ---- correction of a recording for the traits of its model ---- */

/* A share of the means of the elastic traits as effects[MUKCA_FLEET_TERMS]; returns their number.
 * sigma (may be NULL): standard deviation of one more arm. */
int mukca_traits_effects(mukca_effect *effects, double *sigma, const mukca_traits *traits,
                         double share);

/* Change the recorded angles minimally to displace the nominal tip as these effects do, to first
 * order. */
void mukca_traits_correct(mukca_dataset *data, const mukca_chain *chain, const mukca_traits *traits,
                          double share);

/* ---- one more arm with the traits of its model as prior ---- */

/* A coefficient of this arm, rad/(N m). */
typedef struct {
    const mukca_trait *trait;
    double value, low, high; /* with the fleet as prior; 95 % */
    double own_share;        /* share of its information from this arm's data, 0 .. 1 */
} mukca_inherited;

typedef struct {
    /* of the caller */
    const mukca_traits *traits;
    const mukca_dataset *test; /* held-out data, or NULL */
    bool only;                 /* only the traits' means, no elasticity fitted to this arm */
    /* results */
    bool adopted;        /* the traits' prior is in use; else the arm's own fit is better */
    double log_evidence; /* of the traits against the better of the fits without them */
    int n;
    mukca_inherited list[MUKCA_MAX_TRAITS];
} mukca_adoption;

/* Fit the arm with the traits as prior, in the regression of its diagnosis.  If the evidence
 * favours the traits, the errors and effects that the diagnosis applies are those of that fit;
 * otherwise the regression is restored.  Causes and verdict remain those of the arm's own data.
 * Errors: MUKCA_MEMORY. */
mukca_status mukca_adopt(mukca_adoption *adoption, mukca_regression *m, mukca_diagnosis *diagnosis,
                         mukca_error *error);

#endif
