/* The wording of findings of a motion, shared by screen, JSON and page.  As wording.h: each
 * function appends to the text and returns it. */
#ifndef MUKCA_REPORT_WORDING_MOTION_H
#define MUKCA_REPORT_WORDING_MOTION_H

#include "motion/motion.h"
#include "report/wording.h"

/* "2 runs, 60 s of motion; reference: 1". */
const char *mukca_wording_runs(char text[MUKCA_WORDING], const mukca_motion *motion);

/* "viscous friction at joint_3", "mass at links link5 to link6". */
const char *mukca_wording_torque(char text[MUKCA_WORDING], const mukca_finding_group *group,
                                 const mukca_chain *chain);

/* "certain (> 99.9 %, all halves); 1.2 N·m·s/rad [1.1, 1.3]". */
const char *mukca_wording_torque_certainty(char text[MUKCA_WORDING],
                                           const mukca_motion_finding *finding);

/* "mass of link5 61 %, torque gain of joint_2 30 %"; nothing for one effect at one place. */
const char *mukca_wording_torque_alternatives(char text[MUKCA_WORDING],
                                              const mukca_motion_finding *finding,
                                              const mukca_chain *chain);

/* Name of the link or joint at a position. */
const char *mukca_wording_torque_position(const mukca_chain *chain, bool link, int position);

/* Whether a group acts on links. */
bool mukca_wording_torque_on_links(const mukca_finding_group *group);

#endif
