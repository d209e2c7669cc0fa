/* Runs of a moving arm from joint states: a log of lcm-logger, or the lines of `ros2 topic echo
 * --csv` and JSON. */
#ifndef MUKCA_RECORD_RUN_STATES_H
#define MUKCA_RECORD_RUN_STATES_H

#include "io/runs.h"

/* Read a run as mukca_run_read does.  *is: the file has joint states; else nothing is read, and the
 * file is a table.  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_run_states_read(bool *is, mukca_run *run, mukca_pool *pool, const char *path,
                                   const mukca_chain *chain, const mukca_run_options *options,
                                   mukca_error *error);

#endif
