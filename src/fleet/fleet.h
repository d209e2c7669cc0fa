/* Collection of the summaries of arms of one model: sessions, grouped by arm. */
#ifndef MUKCA_FLEET_FLEET_H
#define MUKCA_FLEET_FLEET_H

#include "fleet/summary.h"

/* Summary of a session in the fleet's memory, without the model, which all share. */
typedef struct {
    uint64_t data;
    const char *arm, *path; /* path: its file, for messages */
    int samples;
    double sigma_m;
    double *information, *vector; /* [packed], [terms] */
    int16_t *ripple;              /* [n_joints][MUKCA_FLEET_ORDERS] */
} mukca_fleet_session;

/* Sum of the sessions of one arm. */
typedef struct {
    const char *name;
    int first, end; /* its sessions */
    int samples;
    bool departs;                       /* excluded from the population */
    const double *information, *vector; /* [packed], [terms] */
} mukca_fleet_arm;

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

/* Least probability for it to be called shared. */
#define MUKCA_SHARED 0.5

typedef struct {
    mukca_fleet_model model; /* of the first summary */
    int n_terms, n_sessions, n_arms, capacity;
    mukca_fleet_session *session;
    mukca_fleet_arm *arm; /* set by mukca_fleet_gather */
    mukca_pool pool;
} mukca_fleet;

/* Add a summary read from `path`, which must outlive the fleet.  Errors: MUKCA_INPUT (another
 * model, no possible information), MUKCA_MEMORY. */
mukca_status mukca_fleet_take(mukca_fleet *fleet, const mukca_summary *summary, const char *path,
                              mukca_error *error);

/* Sort the sessions, to make results independent of the order of the files, and sum those of each
 * arm.  Errors: MUKCA_INPUT (the same recording twice), MUKCA_MEMORY. */
mukca_status mukca_fleet_gather(mukca_fleet *fleet, mukca_error *error);

/* Log Bayes factor of an order of ripple, over all sessions of an arm. */
double mukca_fleet_ripple(const mukca_fleet *fleet, int arm, int joint, int order);

/* Copy a session to a summary. */
void mukca_fleet_give(mukca_summary *summary, const mukca_fleet *fleet, int session);

void mukca_fleet_free(mukca_fleet *fleet);

#endif
