/* Next postures of a diagnosis: those that split a finding. */
#ifndef MUKCA_DIAGNOSE_NEXT_POSES_H
#define MUKCA_DIAGNOSE_NEXT_POSES_H

#include "diagnose/diagnose.h"
#include "plan/plan.h"

enum { MUKCA_NEXT_POSES = 10 };

typedef struct {
    int finding; /* index; -1: nothing to distinguish */
    int pair[2]; /* its alternatives that the postures distinguish */
    mukca_plan_socket sockets[MUKCA_PLAN_MAX_SOCKETS];
    int left_out;    /* sockets with samples beyond these, which the plan ignores */
    mukca_plan plan; /* rows refer to `sockets`; zeroed if no posture distinguishes the causes */
} mukca_next_poses;

/* Choose postures in the recorded sockets that best split the first finding with alternatives;
 * plan.n_rows is 0 if there is none or no posture there helps.  Free `plan`.  `stop`
 * (may be NULL) is polled.  Errors: MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status mukca_next_poses_choose(mukca_next_poses *next, const mukca_diagnosis *diagnosis,
                                     const mukca_chain *chain, const mukca_dataset *data,
                                     bool (*stop)(void *context), mukca_error *error);

/* The two most probable alternatives of a finding (-1: of the first that has such) that postures
 * can distinguish, with their measured evidence and noise, as options of a plan; false: none. */
bool mukca_next_poses_pair(mukca_next_poses *next, mukca_plan_options *options,
                           mukca_effect effects[2], const mukca_diagnosis *diagnosis, int finding);

/* Would readings split a finding, into an error of the commands and one of the arm? */
bool mukca_next_poses_need_readings(const mukca_finding *finding);

#endif
