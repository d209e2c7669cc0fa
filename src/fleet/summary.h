/* The summary of a recording: what it says about the coefficients that arms of one model share,
 * the geometry of this arm integrated out. */
#ifndef MUKCA_FLEET_SUMMARY_H
#define MUKCA_FLEET_SUMMARY_H

#include <stdint.h>

#include "diagnose/ripple.h"
#include "fleet/basis.h"

enum {
    MUKCA_FLEET_ORDERS = MUKCA_RIPPLE_ORDERS - 1, /* 2 .. 400 */
    MUKCA_FLEET_PACKED = MUKCA_FLEET_TERMS * (MUKCA_FLEET_TERMS + 1) / 2
};

/* Unit of the log Bayes factors of orders, in which sums are exact in any order; what is beyond
 * +-2047 counts as that. */
#define MUKCA_FLEET_QUANTUM (1.0 / 16)

/* Arms of one model have these in common, but for the tool: all behind the last joint, and the tip.
 */
typedef struct {
    char robot[MUKCA_NAME_SIZE], base[MUKCA_NAME_SIZE], tip[MUKCA_NAME_SIZE];
    int n_joints;
    char joint[MUKCA_MAX_JOINTS][MUKCA_NAME_SIZE];
    uint64_t geometry; /* hash of the nominal origins and axes, to a micrometre and a microradian */
    uint64_t masses;   /* hash of the link masses and their places, to a gram and a micrometre */
} mukca_fleet_model;

typedef struct {
    mukca_fleet_model model;
    char arm[MUKCA_NAME_SIZE];
    uint64_t data; /* hash of the recording */
    int samples;
    double sigma_m; /* noise */
    /* of the coefficients, lower triangle by rows, (N m/rad)^2; times the estimate */
    double information[MUKCA_FLEET_PACKED], vector[MUKCA_FLEET_TERMS];
    int16_t ripple[MUKCA_MAX_JOINTS][MUKCA_FLEET_ORDERS]; /* log Bayes factors, in quanta */
} mukca_summary;

static inline int mukca_fleet_packed(int n_terms)
{
    return n_terms * (n_terms + 1) / 2;
}

/* What of an arm must agree within a fleet. */
void mukca_fleet_model_of(mukca_fleet_model *model, const mukca_chain *chain);

/* Why summaries of the two models cannot be pooled; NULL: they can. */
const char *mukca_fleet_model_differs(const mukca_fleet_model *a, const mukca_fleet_model *b);

/* The summary of a recording from the regression of its diagnosis, which keeps the recording's
 * faults and the causes that are not elastic, and gets the elastic coefficients.  arm and data are
 * left to the caller.  Errors: MUKCA_MEMORY, MUKCA_UNIDENTIFIABLE (no fit). */
mukca_status mukca_summary_take(mukca_summary *summary, mukca_regression *m, mukca_error *error);

/* Hash of a recording: its angles, sockets and measured positions. */
uint64_t mukca_summary_hash(const mukca_dataset *data);

#endif
