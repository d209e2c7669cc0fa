/* Runs of a moving arm from tables. */
#include "io/runs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/list.h"

typedef struct {
    mukca_rows rows;
    const mukca_run_options *options;
    mukca_run_rows samples;
    bool commands; /* efforts are computed from commanded angles, */
    bool current;  /* or are motor currents */
} reader;

/* Recorded velocities differ from the derivative of the angles by more than noise and filters of
 * drivers: by this part, rms. */
#define VELOCITY_ERROR 0.3
/* Steps over which the angles are differentiated on either side, s: encoder steps vanish. */
#define VELOCITY_STEP 0.02

static void check_columns(reader *r)
{
    mukca_table *t = &r->rows.table;
    const mukca_chain *chain = r->rows.chain;
    const mukca_row_columns *c = &r->rows.column;
    const mukca_run_options *o = r->options;
    r->commands = isfinite(o->stiffness[0]) && c->number[MUKCA_COLUMN_EFFORT][0] < 0 &&
                  c->number[MUKCA_COLUMN_COMMAND][0] >= 0;
    r->current = !r->commands && (o->current || r->rows.has_current);
    if (c->number[MUKCA_COLUMN_TIME][0] < 0)
        mukca_table_fail(t, -1, "no column time_s: a run needs the time of each row, s");
    if (r->rows.by_command)
        mukca_table_fail(t, -1, "commanded angles only; a run needs the measured ones");
    for (int j = 0; j < chain->n_joints; j++) {
        const char *name = mukca_chain_joint_name(chain, j);
        const bool has =
            c->number[r->commands ? MUKCA_COLUMN_COMMAND : MUKCA_COLUMN_EFFORT][j] >= 0;
        if (!has)
            mukca_table_fail(t, -1,
                             "no column %s.effort (torque, N m) or %s.current (A); record the "
                             "efforts of the joint states",
                             name, name);
        else if (r->commands ? !isfinite(o->stiffness[j]) : r->current && !isfinite(o->gain[j]))
            mukca_table_fail(t, -1, "no %s of %s; give --%s %s=VALUE",
                             r->commands ? "position gain" : "torque constant", name,
                             r->commands ? "kp" : "current-gain", name);
    }
}

double mukca_run_rows_add(mukca_run_rows *rows, const double *row, int n_joints)
{
    const size_t width = 1 + 3 * (size_t)n_joints;
    const double last = rows->n ? rows->sample[(size_t)(rows->n - 1) * width] : -HUGE_VAL;
    bool complete = isfinite(row[0]);
    for (int j = 0; j < n_joints; j++)
        complete = complete && isfinite(row[1 + j]) && isfinite(row[1 + 2 * n_joints + j]);
    rows->incomplete += !complete;
    if (complete && row[0] < last) return last - row[0];
    rows->repeated += complete && row[0] == last;
    if (!complete || row[0] == last) return 0;
    double *to = mukca_list_append(&rows->sample, &rows->n, sizeof *row * width);
    rows->failed |= !to;
    if (to) memcpy(to, row, sizeof *row * width);
    return 0;
}

static void read_rows(reader *r)
{
    const mukca_run_options *o = r->options;
    const int n = r->rows.chain->n_joints;
    mukca_row row;
    while (mukca_rows_next(&r->rows, &row) && !r->samples.failed) {
        double s[1 + 3 * MUKCA_MAX_JOINTS] = {row.time[0]};
        for (int j = 0; j < n; j++) {
            s[1 + j] = row.q[j];
            s[1 + n + j] = row.velocity[j];
            s[1 + 2 * n + j] = r->commands ? o->stiffness[j] * (row.command[j] - row.q[j])
                                           : row.effort[j] * (r->current ? o->gain[j] : 1);
        }
        const double fell = mukca_run_rows_add(&r->samples, s, n);
        if (fell > 0)
            mukca_table_fail(&r->rows.table, r->rows.column.number[MUKCA_COLUMN_TIME][0],
                             "the time falls by %.3g s; write each run to a file of its own", fell);
    }
}

/* Compare the recorded velocities of a joint with the derivative of its angle. */
static void compare_velocities(const mukca_run *run, const mukca_run_rows *rows, int joint,
                               const mukca_chain *chain, const mukca_run_options *o)
{
    const int n = chain->n_joints;
    double both = 0, own = 0, wanted = 0;
    for (int i = 0, a = 0, b = 0; i < rows->n; i++) {
        while (a < i && run->time[i] - run->time[a] > VELOCITY_STEP) a++;
        while (b + 1 < rows->n && run->time[b] - run->time[i] < VELOCITY_STEP) b++;
        const double v = rows->sample[(size_t)i * (1 + 3 * (size_t)n) + 1 + (size_t)(n + joint)],
                     t = run->time[b] - run->time[a];
        if (!isfinite(v) || !(t > 0) || t > 10 * VELOCITY_STEP) continue; /* a gap */
        const double slope = (run->q[b * n + joint] - run->q[a * n + joint]) / t;
        both += v * slope, own += v * v, wanted += slope * slope;
    }
    const double error = own - 2 * both + wanted, factor = both / fmax(wanted, 1e-300);
    const char *name = mukca_chain_joint_name(chain, joint);
    if (!(own > 0) || error < VELOCITY_ERROR * VELOCITY_ERROR * wanted) return;
    if (both * both > 0.9 * own * wanted)
        mukca_note_format(o->notes,
                          "%s: the velocities of %s are %.3g times the derivative of its angle; "
                          "check the units of time_s, angles and velocities",
                          run->name, name, factor);
    else
        mukca_note_format(o->notes,
                          "%s: the velocities of %s are not the derivative of its angle "
                          "(correlation %.2f); check the columns of joints and time_s",
                          run->name, name, both / sqrt(fmax(own * wanted, 1e-300)));
}

mukca_status mukca_run_rows_take(mukca_run *run, mukca_pool *pool, const mukca_run_rows *rows,
                                 const mukca_chain *chain, const mukca_run_options *o)
{
    const int n = chain->n_joints;
    run->n = rows->n;
    run->time = MUKCA_TAKE(pool, double, rows->n + 1);
    run->q = MUKCA_TAKE(pool, double, rows->n *n + 1);
    run->effort = MUKCA_TAKE(pool, double, rows->n *n + 1);
    if (pool->failed || rows->failed) return MUKCA_MEMORY;
    for (int i = 0; i < rows->n; i++) {
        const double *from = rows->sample + (size_t)i * (1 + 3 * (size_t)n);
        run->time[i] = from[0];
        memcpy(run->q + i * n, from + 1, sizeof(double) * (size_t)n);
        memcpy(run->effort + i * n, from + 1 + 2 * n, sizeof(double) * (size_t)n);
    }
    for (int j = 0; j < n; j++) compare_velocities(run, rows, j, chain, o);
    if (rows->incomplete)
        mukca_note_format(o->notes, "%s: %d rows without time or efforts left out", run->name,
                          rows->incomplete);
    if (rows->repeated)
        mukca_note_format(o->notes, "%s: %d rows that repeat a time left out", run->name,
                          rows->repeated);
    return MUKCA_OK;
}

mukca_status mukca_run_read(mukca_run *run, mukca_pool *pool, const char *path,
                            const mukca_chain *chain, const mukca_run_options *o,
                            mukca_error *error)
{
    reader r = {.options = o};
    const mukca_rows_options options = {
        .kind = MUKCA_HEADER, .format = o->format, .currents = true, .notes = o->notes};
    snprintf(run->name, sizeof run->name, "%.60s", mukca_file_name(path));
    MUKCA_TRY(mukca_rows_open(&r.rows, path, chain, &options, error));
    check_columns(&r);
    run->current = r.current;
    read_rows(&r);
    if (r.rows.table.status == MUKCA_OK &&
        mukca_run_rows_take(run, pool, &r.samples, chain, o) != MUKCA_OK)
        mukca_table_stop(&r.rows.table, mukca_fail(error, MUKCA_MEMORY, "out of memory for %s",
                                                   mukca_file_shown(path)));
    free(r.samples.sample);
    return mukca_rows_close(&r.rows);
}
