/* The wording of a diagnosis: one place for what screen, JSON and page say of causes and verdicts.
 */
#ifndef MUKCA_REPORT_WORDING_H
#define MUKCA_REPORT_WORDING_H

#include "diagnose/next_poses.h"

enum { MUKCA_WORDING = 600 }; /* characters of a text below, its end included */

/* A diagnosis and what it was made of. */
typedef struct {
    const mukca_diagnosis *diagnosis;
    const mukca_chain *chain;
    const mukca_dataset *data, *test; /* test: NULL without --test */
    const mukca_next_poses *next;     /* NULL: none were chosen */
    bool saved;                       /* written as an offsets table */
} mukca_diagnosed;

/* Is it prismatic?  False for -1. */
bool mukca_wording_slides(const mukca_chain *chain, int joint);

/* Does the cause act on the arm?  A moved tool does not. */
bool mukca_wording_on_arm(const mukca_cause *cause);

/* "joint compliance at joint_2", "link bending before joint_3"; joint NULL: "base
 * compliance". */
void mukca_wording_effect(char text[MUKCA_WORDING], mukca_effect_kind kind, const char *joint);

/* The same with what distinguishes the cause from others of its kind: "transmission ripple at
 * joint_2 (240 per turn)". */
void mukca_wording_cause(char text[MUKCA_WORDING], const mukca_cause *cause,
                         const mukca_diagnosed *diagnosed);

/* The same with all that the data cannot distinguish from it: "A, B or C". */
void mukca_wording_rivals(char text[MUKCA_WORDING], const mukca_cause *cause,
                          const mukca_diagnosed *diagnosed);

/* Amplitude with its 95 % interval: "49.2 urad/(N·m) [44.6, 53.7]". */
void mukca_wording_amplitude(char text[MUKCA_WORDING], const mukca_cause *cause,
                             const mukca_chain *chain);

/* "probability > 99.9 %". */
void mukca_wording_probability(char text[MUKCA_WORDING], double probability);

/* What a cause is, in words of its mechanism; no full stop. */
const char *mukca_wording_mechanism(const mukca_cause *cause, const mukca_diagnosed *diagnosed);

/* What to do about a cause; no full stop. */
const char *mukca_wording_remedy(const mukca_cause *cause, const mukca_diagnosed *diagnosed);

/* The verdict in one sentence, however many causes there are; no full stop. */
void mukca_wording_verdict(char text[MUKCA_WORDING], const mukca_diagnosed *diagnosed);

/* "unexplained structure at joint_3, mainly from -20 to 40 degrees: no effect of the catalogue
 * describes it". */
void mukca_wording_unexplained(char text[MUKCA_WORDING], const mukca_diagnosed *diagnosed);

/* What limits the verdict, as sentences: flexibility that could not be tested; "" where nothing. */
void mukca_wording_caveat(char text[MUKCA_WORDING], const mukca_diagnosed *diagnosed);

/* Do the causes make the test data worse, so that they are not certain? */
bool mukca_wording_worse(const mukca_diagnosis *diagnosis);

/* What to do next; no full stop. */
void mukca_wording_next(char text[MUKCA_WORDING], const mukca_diagnosed *diagnosed);

#endif
