/* The wording of a diagnosis, shared by screen, JSON and page. */
#ifndef MUKCA_REPORT_WORDING_H
#define MUKCA_REPORT_WORDING_H

#include "arm/acceptance.h"
#include "diagnose/next_poses.h"

enum { MUKCA_WORDING = 2048 }; /* size of the texts below, with the NUL */

/* Diagnoses of simulated recordings: `runs` with the causes, and as many without. */
typedef struct {
    int runs;
    const mukca_cause *cause; /* main cause, NULL: none, and only recordings without it */
    int found, tied, other, none;
    int false_without; /* verdicts other than `none` without the causes */
} mukca_check;

/* A diagnosis and its inputs. */
typedef struct {
    const mukca_diagnosis *diagnosis;
    const mukca_chain *chain;
    const mukca_dataset *data, *test;   /* test: NULL without --test */
    const mukca_next_poses *next;       /* NULL: not requested */
    const mukca_check *check;           /* NULL: not requested, or not possible */
    const mukca_acceptance *acceptance; /* of its offsets table; NULL: nothing was fitted */
    bool saved;                         /* the table was written */
} mukca_diagnosed;

/* A model and its mean errors, m; NaN: not measured. */
typedef struct {
    const char *name;
    int causes; /* number of causes in the model */
    double cross_validated_m, test_m;
} mukca_step;

enum { MUKCA_MAX_STEPS = MUKCA_MAX_CAUSES + 5 };

/* The errors from the nominal model to the noise floor, each a fit of its own; returns their
 * number. */
int mukca_wording_steps(mukca_step steps[MUKCA_MAX_STEPS], const mukca_diagnosed *diagnosed);

/* Whether a joint is prismatic; false for -1. */
bool mukca_wording_slides(const mukca_chain *chain, int joint);

/* Whether the cause is part of the arm, unlike a moved tool. */
bool mukca_wording_on_arm(const mukca_cause *cause);

/* "joint compliance at joint_2", "link bending before joint_3"; joint NULL: "base
 * compliance". */
void mukca_wording_effect(char text[MUKCA_WORDING], mukca_effect_kind kind, const char *joint);

/* The same with the cause's variant and all indistinguishable rivals: "A, B or C". */
void mukca_wording_rivals(char text[MUKCA_WORDING], const mukca_cause *cause,
                          const mukca_diagnosed *diagnosed);

/* A set of causes: "joint_compliance joint_4 + outlier at session.tsv:14". */
void mukca_wording_set(char text[MUKCA_WORDING], const mukca_cause_set *set,
                       const mukca_diagnosed *diagnosed);

/* Amplitude with its 95 % interval: "49.2 urad/(N·m) [44.6, 53.7]". */
void mukca_wording_amplitude(char text[MUKCA_WORDING], const mukca_cause *cause,
                             const mukca_chain *chain);

/* "probability > 99.9 %". */
void mukca_wording_probability(char text[MUKCA_WORDING], double probability);

/* Description of a cause by its mechanism; no full stop. */
const char *mukca_wording_mechanism(const mukca_cause *cause, const mukca_diagnosed *diagnosed);

/* Remedy of a cause; no full stop. */
const char *mukca_wording_remedy(const mukca_cause *cause, const mukca_diagnosed *diagnosed);

/* The verdict in one sentence for any number of causes; no full stop. */
void mukca_wording_verdict(char text[MUKCA_WORDING], const mukca_diagnosed *diagnosed);

/* "unexplained structure at joint_3, mainly from -20 to 40 degrees: no effect of the catalogue
 * describes it". */
void mukca_wording_unexplained(char text[MUKCA_WORDING], const mukca_diagnosed *diagnosed);

/* "simulated with these postures and this noise: ... was found again in 97 of 100 recordings, tied
 * in 2; without causes nothing was found in 100 of 100". */
void mukca_wording_check(char text[MUKCA_WORDING], const mukca_diagnosed *diagnosed);

/* A recording fault with its place and remedy; no full stop. */
void mukca_wording_fault(char text[MUKCA_WORDING], const mukca_data_fault *fault,
                         const mukca_diagnosed *diagnosed);

/* The effects that are not testable for the same reason as diagnosis->tested[i]: "joint_drift,
 * joint_scale at joint_7 (REASON)".  False: it is testable, its reason belongs to an earlier one,
 * or it is of no interest.  `caveat`: missing masses have been mentioned already. */
bool mukca_wording_untestable(char text[MUKCA_WORDING], int i, const mukca_diagnosed *diagnosed,
                              bool caveat);

/* Limitations of the verdict, as sentences: flexibility that could not be tested; "" for none. */
void mukca_wording_caveat(char text[MUKCA_WORDING], const mukca_diagnosed *diagnosed);

/* Whether the causes increase the error on the test data and are therefore uncertain. */
bool mukca_wording_worse(const mukca_diagnosis *diagnosis);

/* The next step; no full stop. */
void mukca_wording_next(char text[MUKCA_WORDING], const mukca_diagnosed *diagnosed);

#endif
