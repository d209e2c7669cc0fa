/* A simulated recording and its diagnosis. */
#ifndef MUKCA_TESTS_DIAGNOSED_H
#define MUKCA_TESTS_DIAGNOSED_H

#include "diagnose/diagnose.h"
#include "fit/evaluate.h"
#include "scene.h"
#include "scratch.h"

static scene s;
static mukca_dataset data;
static mukca_diagnosis *d;

static inline int set_up(void **state)
{
    d = calloc(1, sizeof *d);
    return d ? scratch_setup(state) : 1;
}

static inline int tear_down(void **state)
{
    mukca_dataset_free(&data);
    mukca_diagnosis_free(d);
    free(d);
    return scratch_teardown(state);
}

/* Record the arm as it is in `s`. */
static inline void record_again(void)
{
    mukca_dataset_free(&data);
    record(&data, &s);
}

/* Record an arm with those effects and 0.1 mm of noise. */
static inline void simulate(const char *effects, uint64_t seed)
{
    set_scene(&s, effects, seed);
    s.how.noise = 1e-4;
    record_again();
}

static inline void diagnose(mukca_diagnose_options options)
{
    mukca_diagnosis_free(d);
    assert_ok(mukca_diagnose(d, &s.chain, &data, &options, &error));
}

#endif
