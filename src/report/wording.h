/* The wording of a diagnosis, shared by screen, JSON and page.
 *
 * Each function appends its text to an empty or begun one (verdict and caveat: an empty one),
 * longer text is truncated, and returns it; MUKCA_WORDS is an empty one, valid in its block.  No
 * sentence ends with a full stop. */
#ifndef MUKCA_REPORT_WORDING_H
#define MUKCA_REPORT_WORDING_H

#include "arm/acceptance.h"
#include "diagnose/next_poses.h"

enum { MUKCA_WORDING = 2048 }; /* size of the texts below, with the NUL */
#define MUKCA_WORDS ((char[MUKCA_WORDING]){""})

/* A diagnosis and its inputs. */
typedef struct {
    const mukca_diagnosis *diagnosis;
    const mukca_chain *chain;
    const mukca_dataset *data, *test;   /* test: NULL without --test */
    const mukca_next_poses *next;       /* NULL: not requested */
    const mukca_acceptance *acceptance; /* of its offsets table; NULL: nothing was fitted */
    bool saved;                         /* the table was written */
} mukca_diagnosed;

/* A model and its mean errors, m; NaN: not measured. */
typedef struct {
    const char *name;
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

const char *mukca_wording_put(char text[MUKCA_WORDING], const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Replace the text: "joint compliance at joint_2", "link bending before joint_3"; joint NULL: "base
 * compliance".  "probability > 99.9 %". */
const char *mukca_wording_effect(char text[MUKCA_WORDING], mukca_effect_kind kind,
                                 const char *joint);
const char *mukca_wording_probability(char text[MUKCA_WORDING], double probability);

/* A finding: "deflection under load, base to joint_2", "transmission ripple at joint_4, order 100
 * [99, 101]", "further" and "also" beside finer findings in its range; its certainty, and with the
 * coefficient: "certain (> 99.9 %, all halves); 73 urad/(N·m) [70, 76] in all"; its members, unless
 * it is one effect at one place. */
const char *mukca_wording_finding(char text[MUKCA_WORDING], const mukca_finding *finding,
                                  const mukca_diagnosed *diagnosed);
const char *mukca_wording_sureness(char text[MUKCA_WORDING], const mukca_finding_group *group);
const char *mukca_wording_certainty(char text[MUKCA_WORDING], const mukca_finding *finding,
                                    const mukca_diagnosed *diagnosed);
const char *mukca_wording_alternatives(char text[MUKCA_WORDING], const mukca_finding *finding,
                                       const mukca_diagnosed *diagnosed);

/* "73 urad/(N·m) [70, 76]": the estimate times `factor`, to two significant digits of the
 * interval's half width and at most `most` decimals; the unit behind its prefix, "": none. */
const char *mukca_wording_estimate(char text[MUKCA_WORDING], const mukca_estimate *estimate,
                                   double factor, const char *prefix, const char *unit, int most);

/* Name of a position along the chain: "base", a joint, "tool". */
const char *mukca_wording_position(const mukca_diagnosed *diagnosed, int position);

/* Index of the one placement that a finding concerns, -1: none. */
int mukca_wording_finding_placement(const mukca_finding *finding);

/* Remedy of a cause. */
const char *mukca_wording_remedy(const mukca_cause *cause, const mukca_diagnosed *diagnosed);

/* A recording fault with its place and remedy. */
const char *mukca_wording_fault(char text[MUKCA_WORDING], const mukca_data_fault *fault,
                                const mukca_diagnosed *diagnosed);

/* The effects that are not testable for the same reason as diagnosis->tested[i]: "joint_drift,
 * joint_scale at joint_7 (REASON)".  Nothing if it is testable, its reason belongs to an earlier
 * one, or it is of no interest. */
const char *mukca_wording_untestable(char text[MUKCA_WORDING], int i,
                                     const mukca_diagnosed *diagnosed);

/* Texts of a diagnosis, each empty if there is nothing to state:
 * verdict: one sentence for any number of causes
 * unexplained: "unexplained structure at joint_3, mainly from -20 to 40 degrees: ..."
 * caveat: limitations of the verdict, as sentences, for example flexibility that was not testable
 * logs: free frames that several pose logs share; several targets
 * angles: readings against commands, and the stream that was fitted
 * efforts: measured efforts that were not used
 * limits: "Detection limits, mrad rms (median over effects): joint_1 0.38, ..."
 * rest: the held-out error that remains, beside the noise
 * next: the next step */
typedef const char *mukca_wording_text(char text[MUKCA_WORDING], const mukca_diagnosed *diagnosed);
mukca_wording_text mukca_wording_verdict, mukca_wording_unexplained, mukca_wording_caveat,
    mukca_wording_logs, mukca_wording_angles, mukca_wording_efforts, mukca_wording_limits,
    mukca_wording_rest, mukca_wording_next;

#endif
