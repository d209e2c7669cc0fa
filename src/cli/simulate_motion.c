/* mukca simulate --motion: runs of a moving arm as a table, and its effects. */
#include "cli/simulate.h"

typedef struct {
    FILE *stream;
    char separator;
    int n_joints;
} table;

/* Columns of the angles, or those of another name for each joint. */
static void write_names(const table *t, const mukca_chain *chain, const char *suffix)
{
    for (int j = 0; j < t->n_joints; j++)
        fprintf(t->stream, "%c%s%s", t->separator, mukca_chain_joint_name(chain, j), suffix);
}

static void write_row(void *context, double time, const double *q, const double *effort)
{
    const table *t = context;
    fprintf(t->stream, "%.6f", time);
    for (int j = 0; j < t->n_joints; j++) fprintf(t->stream, "%c%.9f", t->separator, q[j]);
    for (int j = 0; j < t->n_joints; j++) fprintf(t->stream, "%c%.9g", t->separator, effort[j]);
    fputc('\n', t->stream);
}

mukca_status cli_write_motion(FILE *stream, const mukca_simulated_motion *motion, char separator)
{
    table t = {stream, separator, motion->chain->n_joints};
    fputs("time_s", stream);
    write_names(&t, motion->chain, "");
    write_names(&t, motion->chain, ".effort");
    fputc('\n', stream);
    return mukca_simulate_motion(motion, write_row, &t);
}

void cli_write_torques(FILE *stream, const mukca_simulated_motion *motion)
{
    fputs("effect\tjoint\tparameter\tunit\tvalue\tsigma\tprobability\n", stream);
    for (int e = 0; e < motion->n_effects; e++) {
        const mukca_simulated_torque *t = &motion->effects[e];
        const mukca_simulated_kind *kind = &mukca_simulated_kinds[t->kind];
        const char *joint = t->joint < 0 ? "-" : mukca_chain_joint_name(motion->chain, t->joint);
        for (int i = 0; i <= kind->most; i++) { /* the variant last */
            const bool last = i == kind->most;
            const mukca_simulated_value *v = last ? &kind->variant : &kind->value[i];
            if (v->name)
                fprintf(stream, "%s\t%s\t%s\t%s\t%.17g\t0\t1\n", kind->name, joint, v->name,
                        v->unit, last ? t->variant : t->value[i]);
        }
    }
}
