/* Joint columns: a mix-up that explains data that do not fit the arm; those that determine less
 * than they seem to. */
#include "fit/mismatch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "effect/catalogue.h"
#include "fit/align.h"
#include "model/dataset_subset.h"

/* Ratio of the errors after and before a change below which the change is no coincidence: real
 * errors of origins reach 1 cm at the tip, those of a wrong column 10 cm and more. */
static const double explained = 0.2, origins = 10e-3;
/* A less simple change must reduce the error by this factor: reversing a joint with little
 * influence on the ball changes the error by less. */
static const double simpler = 0.5;
/* MOST_PATTERNS: up to this number of joints, all patterns of reversed joints are tried; beyond,
 * single joints. */
enum { MOST_PATTERNS = 8, MOST_SAMPLES = 500 };

static const mukca_mismatch none = {.exchanged = {-1, -1}, .shifted = -1, .coupled = -1};

typedef struct {
    const mukca_chain *chain;
    mukca_dataset *data;
    const double *q; /* as recorded */
    bool free_base, free_tool;
    bool failed; /* out of memory */
} search;

/* Mean error of the nominal model, m. */
static double measure(search *s)
{
    if (s->data->n_sockets == 0 && (s->free_base || s->free_tool)) {
        mukca_geometry geometry;
        mukca_alignment alignment;
        mukca_geometry_set(&geometry, s->chain, NULL);
        s->failed |=
            !mukca_align(&alignment, &geometry, s->data,
                         &(mukca_align_options){.tracker = s->free_base, .target = s->free_tool});
        return alignment.mean_m;
    }
    mukca_score mean, *scores = calloc(mukca_evaluate_room(s->data), sizeof *scores);
    s->failed |=
        !scores || mukca_evaluate(scores, &mean, &(mukca_model){.chain = s->chain}, s->data) < 0;
    free(scores);
    return s->failed ? (double)NAN : mean.mae;
}

/* Keep the change if it reduces the error by enough. */
static void try(mukca_mismatch *best, search *s, const mukca_mismatch *change)
{
    const mukca_dataset *d = s->data;
    for (int r = 0; r < d->n_rows; r++) {
        const double *from = s->q + r * d->n_joints;
        double *q = d->q + r * d->n_joints;
        for (int j = 0; j < d->n_joints; j++)
            q[j] = (change->reversed >> j & 1 ? -1 : 1) * from[j] +
                   (j == change->shifted ? change->shift : 0);
        if (change->coupled >= 0) q[change->coupled] += change->sign * from[change->with];
        if (change->exchanged[0] < 0) continue;
        q[change->exchanged[0]] = from[change->exchanged[1]];
        q[change->exchanged[1]] = from[change->exchanged[0]];
    }
    const double after = measure(s);
    if (!(after < (best->found ? simpler * best->after_m : explained * best->before_m))) return;
    const double before = best->before_m;
    *best = *change;
    best->found = true;
    best->before_m = before;
    best->after_m = after;
}

/* All changes, the simple ones first. */
static void try_all(mukca_mismatch *best, search *s)
{
    const int n = s->chain->n_joints;
    mukca_mismatch change = none;
    for (int j = 0; j < n; j++, change = none) {
        change.reversed = 1u << j;
        try(best, s, &change);
    }
    for (int a = 0; a < n; a++)
        for (int b = a + 1; b < n; b++, change = none) {
            change.exchanged[0] = a, change.exchanged[1] = b;
            try(best, s, &change);
        }
    for (int j = 0; j < n; j++)
        for (int quarter = -1; quarter <= 2; quarter++, change = none) {
            const int element = s->chain->joint_element[j];
            if (!quarter || s->chain->element[element].type == MUKCA_PRISMATIC) continue;
            change.shifted = j, change.shift = quarter * M_PI / 2;
            try(best, s, &change);
        }
    for (int pair = 0; pair < 2 * n * n; pair++, change = none) {
        change.coupled = pair / 2 % n, change.with = pair / 2 / n, change.sign = pair % 2 ? -1 : 1;
        if (change.coupled != change.with) try(best, s, &change);
    }
    for (unsigned pattern = 1; n <= MOST_PATTERNS && pattern < 1u << n; pattern++) {
        change.reversed = pattern;
        if (pattern & (pattern - 1)) try(best, s, &change); /* several joints */
    }
}

mukca_status mukca_mismatch_find(mukca_mismatch *mismatch, const mukca_chain *chain,
                                 const mukca_dataset *data, bool free_base, bool free_tool,
                                 mukca_error *error)
{
    mukca_dataset part = {0};
    *mismatch = none;
    const mukca_status status = mukca_part_take(&part, data, MOST_SAMPLES, error);
    if (status != MUKCA_OK) return status;
    const size_t size = (size_t)part.n_rows * (size_t)part.n_joints * sizeof *part.q;
    double *q = malloc(size + 1);
    search s = {.chain = chain,
                .data = &part,
                .q = q,
                .free_base = free_base,
                .free_tool = free_tool,
                .failed = !q};
    if (q && part.q) {
        memcpy(q, part.q, size);
        mismatch->before_m = measure(&s);
        if (mismatch->before_m > origins) try_all(mismatch, &s);
    }
    free(q);
    mukca_dataset_free(&part);
    return s.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
}

/* ---- columns that determine less than they seem to ---- */

/* Postures of the shortest run of equal angles that is no chance; a joint moves between postures by
 * more than this, rad (m of a sliding joint). */
enum { SHORTEST = 4 };
static const double moved = 5e-3;

/* Is q_b + factor q_a the same in all samples? */
static bool is_constant(const mukca_dataset *data, int b, int a, double factor)
{
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (int row = 0; row < data->n_rows && !(most - least >= MUKCA_LEAST_RANGE); row++) {
        const double *q = data->q + (size_t)row * (size_t)data->n_joints;
        const double value = q[b] + factor * q[a];
        least = fmin(least, value), most = fmax(most, value);
    }
    return !(most - least >= MUKCA_LEAST_RANGE);
}

/* Have the joints other than j moved between two successive samples? */
static bool is_other_posture(const mukca_dataset *data, int row, int j)
{
    const double *q = data->q + (size_t)row * (size_t)data->n_joints;
    for (int i = 0; i < data->n_joints; i++)
        if (i != j && fabs(q[i] - q[i - data->n_joints]) > moved) return true;
    return false;
}

/* Note a joint with the same angle, to the last digit, in one run of postures and in no two
 * successive ones elsewhere: programs that hold a joint on purpose do it more often. */
static void note_run(mukca_note_fn *note, void *context, const mukca_chain *chain,
                     const mukca_dataset *data, int j)
{
    int postures = 1, equal = 0, length = 1, most = 0, first = 0, from = 0, to = 0;
    for (int row = 1; row < data->n_rows; row++) {
        const double *q = data->q + (size_t)row * (size_t)data->n_joints + j;
        const bool same = q[0] == q[-data->n_joints] && data->file[row] == data->file[row - 1];
        const bool other = is_other_posture(data, row, j);
        postures += other;
        equal += same && other;
        length = same ? length + other : 1;
        if (!same) first = row;
        if (length >= most) most = length, from = first, to = row;
    }
    if (most >= SHORTEST && equal == most - 1 && 2 * most < postures)
        mukca_note_format(note, context,
                          "%s reads %.6g in rows %d to %d%s%s while other joints move, and never "
                          "the same in successive postures elsewhere; if it moved, check cable, "
                          "encoder and drive, and remove these rows",
                          mukca_chain_joint_name(chain, j),
                          data->q[(size_t)to * (size_t)data->n_joints + (size_t)j], data->row[from],
                          data->row[to], data->n_files > 1 ? " of " : "",
                          data->n_files > 1 ? data->files[data->file[to]] : "");
}

void mukca_columns_note(mukca_note_fn *note, void *context, const mukca_chain *chain,
                        const mukca_dataset *data)
{
    char still[160] = "";
    mukca_text list = MUKCA_TEXT(still);
    int n_still = 0;
    for (int b = 0; b < data->n_joints; b++) {
        if (is_constant(data, b, b, 0)) {
            mukca_text_put(&list, "%s%s", n_still++ ? ", " : "", mukca_chain_joint_name(chain, b));
            continue;
        }
        note_run(note, context, chain, data, b);
        for (int a = 0; a < b; a++)
            for (int sign = -1; sign <= 1; sign += 2)
                if (is_constant(data, b, a, sign) && !is_constant(data, a, a, 0))
                    mukca_note_format(note, context,
                                      "the columns of %s and %s %s in all samples: a wrong column, "
                                      "or a joint that follows the other; their offsets cannot be "
                                      "told apart",
                                      mukca_chain_joint_name(chain, a),
                                      mukca_chain_joint_name(chain, b),
                                      sign < 0 ? "differ by a constant" : "have a constant sum");
    }
    if (n_still && n_still < data->n_joints)
        mukca_note_format(note, context,
                          "did not move in any sample: %s; if it was moved, its column or encoder "
                          "is stuck, and no result is valid",
                          still);
}
