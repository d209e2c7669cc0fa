/* Columns of the search of a diagnosis, as regressors for other methods.
 *
 * usage: columns URDF SESSION OUT [EFFECT,...]
 *   EFFECT    left out of the catalogue
 *   OUT.tsv   a line for each column: its item (a possible cause) and term, the item's own terms
 *             without those for errors of the masses, and its label as in `diagnose --json`:
 *             effect, varies_with, from, to ("outlier": of one sample); the product of the column
 *             with the response, for checks
 *   OUT.f64   rows of doubles: number of the posture (-1: none), response, columns
 *
 * The columns are those of the last search, linearised at its best set and chosen by its scan,
 * per unit of their prior, whitened by the family of the noise, in units of the noise.  With the
 * geometry's columns X, prior sigmas D and 1 + D X'X D = L L', the rows of Q = [X D; 1] L'^-1 are
 * orthonormal columns.  The components along them are subtracted from [E; 0] and [y; 0], so that
 * ordinary regression on what is left equals one with the geometry integrated out (R. Frisch, F.
 * Waugh, Econometrica 1, 1933; the last rows are the prior's). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "diagnose/findings.h"
#include "diagnose/identify.h"
#include "infer/given.h"
#include "io/dataset.h"
#include "io/urdf.h"

typedef struct {
    mukca_chain chain;
    mukca_dataset data;
    mukca_regression regression;
    mukca_diagnosis diagnosis; /* faults of the recording */
    mukca_search search;
    mukca_diagnose_options options;
    unsigned char disabled[MUKCA_EFFECT_COUNT];
    mukca_question question;
    mukca_error error;
} exam;

static const char *position(const exam *x, int at)
{
    return at < 0                    ? "base"
           : at >= x->chain.n_joints ? "tool"
                                     : mukca_chain_joint_name(&x->chain, at);
}

static void write_labels(FILE *out, const exam *x)
{
    const mukca_search *search = &x->search;
    fputs("item\tterm\town\teffect\tvaries_with\tfrom\tto\tproduct\n", out);
    for (int i = 0; i < x->question.n_items; i++) {
        const mukca_item *item = &x->question.item[i];
        const mukca_candidate *h = &search->all.list[search->kept[i]];
        const bool outlier = mukca_candidate_class(h) == MUKCA_CLASS_OUTLIER;
        mukca_label l = {.effect = -1};
        if (!outlier)
            l = mukca_candidate_label(h, &x->regression.recording, &x->regression.unknowns);
        if (l.apart) l.from = l.to = x->chain.n_joints;
        for (int t = 0; t < item->terms; t++)
            fprintf(out, "%d\t%d\t%d\t%s\t%s\t%s\t%s\t%.9g\n", i, t, mukca_candidate_own_terms(h),
                    l.effect < 0 ? "" : mukca_effect_table[l.effect]->name,
                    outlier ? "outlier" : mukca_varies_name[l.family], position(x, l.from),
                    position(x, l.to), x->question.g[item->at + t]);
    }
}

/* x := L^-1 x of the geometry's posterior. */
static void solve_forward(double *x, const mukca_posterior *p)
{
    for (int i = 0; i < p->n; i++) {
        for (int k = 0; k < i; k++) x[i] -= p->factor[i * p->n + k] * x[k];
        x[i] /= p->factor[i * p->n + i];
    }
}

/* Posture of a row of the regression. */
static int posture_of(const mukca_recording *r, int row)
{
    const int sample = row / r->dim;
    return sample < r->n_samples ? r->posture[r->order[sample]] : -1;
}

/* Scratch: q[geometry], row[columns + 2], along[geometry][columns]. */
static void write_rows(FILE *out, const exam *x, double *q, double *row, double *along)
{
    const mukca_scan *s = &x->search.scan;
    const mukca_question *all = &x->question;
    const mukca_linearisation *linear = &x->regression.linear;
    const double root = sqrt(s->precision);
    const int n = all->n_columns;
    mukca_question_copy(along, n, all, (mukca_span){0, n}, (mukca_span){s->n_rows, s->n});
    for (int i = 0; i < s->n_rows + s->n; i++) {
        const bool sample = i < s->n_rows;
        const double *white = s->white + (long)i * linear->stride;
        for (int t = 0; t < s->n; t++)
            q[t] = sample ? root * white[t] * s->prior[t] : i - s->n_rows == t;
        solve_forward(q, &x->regression.evidence.posterior);
        row[0] = sample ? posture_of(&x->regression.recording, i) : -1;
        row[1] = sample ? root * white[linear->y] : 0;
        memset(row + 2, 0, sizeof *row * (size_t)n);
        if (sample) mukca_question_copy(row + 2, n, all, (mukca_span){0, n}, (mukca_span){i, 1});
        for (int t = 0; t < s->n; t++) {
            row[1] -= q[t] * s->z[t];
            for (int k = 0; k < n; k++) row[2 + k] -= q[t] * along[t * n + k];
        }
        fwrite(row, sizeof *row, (size_t)n + 2, out);
    }
}

static FILE *create(const char *path, const char *ending)
{
    char name[4096];
    snprintf(name, sizeof name, "%s%s", path, ending);
    FILE *out = fopen(name, "wb");
    if (!out) fprintf(stderr, "columns: %s: cannot be written\n", name);
    return out;
}

/* As the diagnosis begins, up to its last search; then that search's columns. */
static mukca_status find(exam *x, mukca_pool *pool)
{
    mukca_regression *m = &x->regression;
    const mukca_recording_options recording = {.mass_spread = 0.1};
    mukca_status status = mukca_regression_create(m, &x->chain, &x->data, &recording, &x->error);
    if (status != MUKCA_OK) return status;
    if (!mukca_screening_run(&x->diagnosis, m))
        return mukca_fail(&x->error, MUKCA_INPUT, "the samples do not fit this arm");
    mukca_regression_fit(m, 6, MUKCA_FIT_ALL);
    x->search = (mukca_search){.m = m, .diagnosis = &x->diagnosis, .options = &x->options};
    status = mukca_identify_run(&x->search, &x->error);
    if (status != MUKCA_OK) return status;
    if (!mukca_scan_aim(&x->search.scan, m->unknowns.family) ||
        !mukca_scan_question(&x->question, &x->search.scan, pool, x->search.kept, x->search.n_kept))
        return mukca_fail(&x->error, MUKCA_MEMORY, "no columns");
    return MUKCA_OK;
}

static bool disable(exam *x, char *list)
{
    for (char *name = strtok(list, ","); name; name = strtok(NULL, ",")) {
        const int kind = mukca_effect_find(name);
        if (kind < 0) return false;
        x->disabled[kind] = 1;
    }
    return true;
}

int main(int argc, char **argv)
{
    static exam x;
    const mukca_urdf_options arm = {.base = "base", .tip = "ball"};
    if (argc < 4 || argc > 5 || (argc == 5 && !disable(&x, argv[4]))) {
        fputs("usage: columns URDF SESSION OUT [EFFECT,...]\n", stderr);
        return 2;
    }
    x.options.disabled = x.disabled;
    mukca_pool pool = {0};
    if (mukca_urdf_load(&x.chain, argv[1], &arm, &x.error) != MUKCA_OK ||
        mukca_dataset_load(&x.data, &x.chain, (const char *const *)(argv + 2), 1, NULL, &x.error) !=
            MUKCA_OK ||
        find(&x, &pool) != MUKCA_OK) {
        fprintf(stderr, "columns: %s\n", x.error.text);
        return 3;
    }
    double *q = MUKCA_TAKE(&pool, double, x.search.scan.n + 1),
           *row = MUKCA_TAKE(&pool, double, x.question.n_columns + 2),
           *along = MUKCA_TAKE(&pool, double, x.search.scan.n *x.question.n_columns + 1);
    FILE *labels = create(argv[3], ".tsv"), *rows = create(argv[3], ".f64");
    if (!labels || !rows || pool.failed) return 6;
    write_labels(labels, &x);
    write_rows(rows, &x, q, row, along);
    const bool written = !fclose(labels) & !fclose(rows);
    mukca_pool_free(&pool);
    mukca_identify_free(&x.search);
    mukca_regression_free(&x.regression);
    mukca_dataset_free(&x.data);
    return written ? 0 : 6;
}
