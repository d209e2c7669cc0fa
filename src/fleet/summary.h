/* Summary of a recording: its information on the coefficients shared by arms of one model, with the
 * geometry of this arm marginalised.  The coefficients are all elastic ones of the chain. */
#ifndef MUKCA_FLEET_SUMMARY_H
#define MUKCA_FLEET_SUMMARY_H

#include <stdint.h>

#include "diagnose/regression.h"
#include "diagnose/ripple.h"

enum {
    /* Compliance of each joint, link bending before each but the first, and the compliance of the
     * base, which precedes the first. */
    MUKCA_FLEET_TERMS = 2 * MUKCA_MAX_JOINTS,
    MUKCA_FLEET_ORDERS = MUKCA_RIPPLE_ORDERS - 1, /* 2 .. 400 */
    MUKCA_FLEET_PACKED = MUKCA_FLEET_TERMS * (MUKCA_FLEET_TERMS + 1) / 2
};

/* Half-width of a 95 % interval in sigmas: the 0.975 quantile of the normal distribution. */
#define MUKCA_FLEET_INTERVAL 1.959963984540054

/* Unit of the log Bayes factors of orders, which makes sums exact in any order; clipped at
 * +-2047. */
#define MUKCA_FLEET_QUANTUM (1.0 / 16)

/* Prior of a coefficient, rad/(N m). */
typedef struct {
    double mean, sigma;
} mukca_fleet_prior;

/* Number of coefficients, and the i-th (without value). */
int mukca_fleet_terms(int n_joints);
mukca_effect mukca_fleet_term(int i, int n_joints);

/* Remove from the regression all elastic causes, unknown functions, which would absorb elasticity,
 * and the gear harmonics of a joint (-1: none). */
void mukca_fleet_strip(mukca_regression *m, int joint);

/* Append the elastic coefficients to the causes, with prior[terms], each with one coefficient for
 * all masses.  A coefficient without influence on this recording is omitted.  Fit afterwards.
 * False: no space. */
bool mukca_fleet_add(mukca_regression *m, const mukca_fleet_prior *prior);

/* Index of a gear harmonic among the causes; added if absent, with a prior size chosen by evidence;
 * -1: no space. */
int mukca_fleet_add_harmonic(mukca_regression *m, int joint, int order);

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

/* Summary of a recording from the regression of its diagnosis.  The regression keeps recording
 * faults and causes that are not elastic, and gets the elastic coefficients.  The caller sets arm
 * and data.  Errors: MUKCA_MEMORY, MUKCA_UNIDENTIFIABLE (no fit). */
mukca_status mukca_summary_take(mukca_summary *summary, mukca_regression *m, mukca_error *error);

/* Hash of a recording: its angles, sockets and measured positions. */
uint64_t mukca_summary_hash(const mukca_dataset *data);

#endif
