/* Summaries of the arms of one model, gathered: sessions, and the arms that they belong to. */
#ifndef MUKCA_FLEET_FLEET_H
#define MUKCA_FLEET_FLEET_H

#include "fleet/summary.h"

/* A session's summary in the fleet's memory: what all have in common is kept once. */
typedef struct {
    uint64_t data;
    const char *arm, *path; /* path: of the file that it came from, for messages */
    int samples;
    double sigma_m;
    double *information, *vector; /* [packed], [terms] */
    int16_t *ripple;              /* [n_joints][MUKCA_FLEET_ORDERS] */
} mukca_fleet_session;

/* The sessions of one arm added up. */
typedef struct {
    const char *name;
    int first, end; /* its sessions */
    int samples;
    bool departs;                       /* it is no part of the population */
    const double *information, *vector; /* [packed], [terms] */
} mukca_fleet_arm;

typedef struct {
    mukca_fleet_model model; /* of the first summary */
    int n_terms, n_sessions, n_arms, capacity;
    mukca_fleet_session *session;
    mukca_fleet_arm *arm; /* by mukca_fleet_gather */
    mukca_pool pool;
} mukca_fleet;

/* Add a summary read from `path`, which must outlive the fleet.  Errors: MUKCA_INPUT (another
 * model, no possible information), MUKCA_MEMORY. */
mukca_status mukca_fleet_take(mukca_fleet *fleet, const mukca_summary *summary, const char *path,
                              mukca_error *error);

/* Order the sessions, so that results do not depend on the order of the files, and add up those of
 * each arm.  Errors: MUKCA_INPUT (the same recording twice), MUKCA_MEMORY. */
mukca_status mukca_fleet_gather(mukca_fleet *fleet, mukca_error *error);

/* Log Bayes factor of an order of ripple by all sessions of an arm. */
double mukca_fleet_ripple(const mukca_fleet *fleet, int arm, int joint, int order);

/* A session as a summary again. */
void mukca_fleet_give(mukca_summary *summary, const mukca_fleet *fleet, int session);

void mukca_fleet_free(mukca_fleet *fleet);

#endif
