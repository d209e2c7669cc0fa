/* diagnose --check: the diagnosis of simulated recordings with its own postures, noise and causes,
 * one after the other in as many threads as there are processors. */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/text.h"
#include "cli/diagnose.h"
#include "diagnose/cause.h"
#include "model/dataset_subset.h"
#include "simulate/simulate.h"

enum { MOST_THREADS = 64 };

typedef enum { FOUND, TIED, OTHER, NONE, OUTCOMES } outcome;

typedef struct {
    const mukca_diagnosed *result;
    mukca_diagnose_options options;
    mukca_replicate_task replicate[2]; /* without and with the causes */
    mukca_corrected arm[2];
    mukca_replicate_motion motions[MUKCA_MAX_CAUSES];
    /* shared by the threads, under the lock */
    pthread_mutex_t lock;
    cli_call *call;
    mukca_check *check;
    int begun;
    mukca_status status;
} check_task;

/* The main cause: the first one on the arm, else the first. */
static const mukca_cause *main_cause(const mukca_diagnosis *d)
{
    for (int i = 0; i < d->n_causes; i++)
        if (mukca_wording_on_arm(&d->causes[i])) return &d->causes[i];
    return d->n_causes ? &d->causes[0] : NULL;
}

static outcome judge(const mukca_diagnosis *d, const mukca_cause *main)
{
    bool tied = false;
    for (int i = 0; i < d->n_causes && main; i++) {
        const mukca_cause *c = &d->causes[i];
        const bool sure = c->probability >= 1 - MUKCA_DOUBT && !c->n_ties && !c->or_unknown;
        if (c->effect.kind == main->effect.kind && c->effect.joint == main->effect.joint &&
            c->effect.placement == main->effect.placement && c->socket == main->socket)
            return sure ? FOUND : TIED;
        for (int t = 0; t < c->n_ties; t++)
            tied |=
                c->ties[t].effect == main->effect.kind && c->ties[t].joint == main->effect.joint;
    }
    return tied ? TIED : d->n_causes > 0 || d->verdict != MUKCA_VERDICT_NONE ? OTHER : NONE;
}

static bool go_on(void *context, double share, const char *doing)
{
    (void)context, (void)share, (void)doing;
    return !cli_interrupted();
}

/* Simulate and diagnose recording `index`: odd ones without the causes. */
static mukca_status run_one(outcome *found, const check_task *task, mukca_diagnosis *d, int index,
                            mukca_error *error)
{
    const bool with = index % 2 == 0;
    mukca_dataset data;
    mukca_status status =
        mukca_simulate_replicate(&data, &task->replicate[with], (uint64_t)index / 2 + 1, error);
    if (status != MUKCA_OK) return status;
    status = mukca_diagnose(d, task->result->chain, &data, &task->options, error);
    if (status == MUKCA_OK) *found = judge(d, with ? task->check->cause : NULL);
    mukca_diagnosis_free(d);
    mukca_dataset_free(&data);
    return status;
}

/* Diagnose recordings until all are begun, and count the outcomes; without a cause, only those
 * without. */
static void *work(void *context)
{
    check_task *task = context;
    mukca_check *c = task->check;
    int *const count[OUTCOMES] = {&c->found, &c->tied, &c->other, &c->none};
    const int by = c->cause ? 1 : 2, total = 2 * c->runs / by;
    mukca_diagnosis *d = calloc(1, sizeof *d);
    pthread_mutex_lock(&task->lock);
    if (!d) task->status = cli_fail(task->call, MUKCA_MEMORY, "out of memory for --check");
    while (d && task->status == MUKCA_OK && task->begun < total) {
        const int index = task->begun * by + by - 1;
        outcome found = NONE;
        mukca_error error;
        cli_progress(task->call, "diagnosing simulations", task->begun++, total);
        pthread_mutex_unlock(&task->lock);
        const mukca_status status = run_one(&found, task, d, index, &error);
        pthread_mutex_lock(&task->lock);
        if (status != MUKCA_OK && task->status == MUKCA_OK) {
            if (status != MUKCA_INTERRUPTED) task->call->error = error;
            task->status = status;
        }
        if (index % 2 == 0)
            ++*count[found];
        else
            c->false_without += found != NONE;
    }
    pthread_mutex_unlock(&task->lock);
    free(d);
    return NULL;
}

static mukca_status run_all(check_task *task)
{
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    pthread_t thread[MOST_THREADS];
    int n = 0;
    while (n < MOST_THREADS && n < (processors > 1 ? processors : 1) &&
           pthread_create(&thread[n], NULL, work, task) == 0)
        n++;
    if (n == 0) work(task);
    while (n > 0) pthread_join(thread[--n], NULL);
    return task->status;
}

/* Moved tools among the causes. */
static void find_motions(check_task *task)
{
    const mukca_diagnosis *d = task->result->diagnosis;
    for (int i = 0; i < d->n_causes; i++) {
        const mukca_cause *c = &d->causes[i];
        if (mukca_wording_on_arm(c)) continue;
        mukca_replicate_motion *m = &task->motions[task->replicate[1].n_motions++];
        *m = (mukca_replicate_motion){
            .socket = c->socket, .row = c->creep ? 0 : c->row, .file = c->file};
        memcpy(m->shift, c->effect.coefficient, sizeof m->shift);
    }
}

/* Reason why the recording cannot be simulated, or NULL. */
static const char *find_obstacle(const mukca_diagnosis *d, const mukca_dataset *data)
{
    if (d->verdict == MUKCA_VERDICT_UNTESTABLE || !d->applied.fitted) return "nothing was fitted";
    if (d->logs.base_per_log || d->logs.tool_per_log || data->n_targets > 1)
        return "logs with frames or targets of their own are not simulated";
    for (int e = 0; e < d->applied.n_effects; e++)
        if (mukca_effect_table[d->applied.effects[e].kind]->needs & MUKCA_NEEDS_MASSES &&
            d->chain->n_masses == 0)
            return "the causes need link masses (--inertials FILE)";
    return NULL;
}

/* The arm, its noise and its moved tools, as fitted; false: no memory. */
static bool prepare(check_task *task, mukca_pool *pool)
{
    const mukca_diagnosed *r = task->result;
    const mukca_diagnosis *d = r->diagnosis;
    const mukca_applied *a = &d->applied;
    int *posture = MUKCA_TAKE(pool, int, r->data->n_rows);
    if (!pool->failed) mukca_postures_find(posture, pool, r->data);
    for (int with = 0; with < 2; with++) {
        mukca_corrected *arm = &task->arm[with];
        arm->chain = *d->chain;
        arm->geometry = a->geometry;
        for (int k = 0; k < arm->chain.n_elements; k++) { /* recorded angles can be outside */
            arm->chain.element[k].lower = -HUGE_VAL;
            arm->chain.element[k].upper = HUGE_VAL;
        }
        task->replicate[with] = (mukca_replicate_task){.arm = arm,
                                                       .data = r->data,
                                                       .posture = posture,
                                                       .tracker = a->tracker,
                                                       .noise = d->sigma_m,
                                                       .rotation = d->sigma_rotation_rad,
                                                       .correlation = d->rho,
                                                       .shared = d->shared,
                                                       .motions = task->motions};
    }
    task->arm[1].n_effects = a->n_effects;
    memcpy(task->arm[1].effects, a->effects, sizeof *a->effects * (size_t)a->n_effects);
    find_motions(task);
    return !pool->failed;
}

mukca_status cli_diagnosis_check(cli_call *call, cli_diagnosis *d)
{
    const char *obstacle = find_obstacle(&d->diagnosis, d->result.data);
    if (obstacle) {
        mukca_note_format(cli_note, call, "--check was left out: %s", obstacle);
        return MUKCA_OK;
    }
    check_task *task = MUKCA_TAKE(&call->pool, check_task, 1);
    d->check = (mukca_check){.runs = call->common->check, .cause = main_cause(&d->diagnosis)};
    if (!task) return cli_fail(call, MUKCA_MEMORY, "out of memory for --check");
    *task = (check_task){.call = call,
                         .check = &d->check,
                         .result = &d->result,
                         .options = d->options,
                         .lock = PTHREAD_MUTEX_INITIALIZER};
    task->options.test = NULL;
    task->options.no_folds = true;
    task->options.applied = task->options.mounting = false;
    task->options.go_on = NULL;
    task->options.progress = go_on;
    if (!prepare(task, &call->pool))
        return cli_fail(call, MUKCA_MEMORY, "out of memory for --check");
    const mukca_status status = run_all(task);
    if (status == MUKCA_OK) d->result.check = &d->check;
    return status;
}
