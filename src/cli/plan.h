/* Declarations shared by the files of `mukca plan`. */
#ifndef MUKCA_CLI_PLAN_H
#define MUKCA_CLI_PLAN_H

#include "cli/simulate.h"
#include "diagnose/next_poses.h"

typedef struct {
    cli_common common;
    cli_list separate, places;
    bool settle;
    int rows, seed;
    double noise, tilt, clearance;
} cli_plan_options;

typedef struct {
    cli_call *call;
    cli_model *model;          /* of the call's session */
    const mukca_dataset *data; /* likewise */
    int n_sockets;
    mukca_plan_socket sockets[MUKCA_PLAN_MAX_SOCKETS];
    mukca_place known[CLI_MAX_PLACES]; /* placements that causes may name */
    cli_simulated causes;
    mukca_diagnosis diagnosis;
    mukca_plan_options options;
    mukca_plan plan;
    double payload;  /* kg, for the proposed postures; 0: none */
    double unloaded; /* evidence from equally many postures without payload */
} cli_plan;

/* Write the postures as a table to -o or standard output. */
mukca_status cli_plan_write(cli_plan *plan);

json_t *cli_plan_json(const cli_plan *plan);

/* Print one screen. */
void cli_plan_print(cli_plan *plan);

#endif
