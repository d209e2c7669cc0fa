/* diagnose --check: the diagnosis of simulated recordings with its own postures, noise and causes.
 *
 * Each process diagnoses every n-th recording and writes one outcome after the other to a pipe;
 * outcomes are shorter than PIPE_BUF, and therefore not mixed. */
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/note.h"
#include "cli/diagnose.h"
#include "diagnose/cause.h"
#include "model/dataset_subset.h"
#include "simulate/simulate.h"

enum { MOST_PROCESSES = 64 };

typedef enum { FOUND, TIED, OTHER, NONE, OUTCOMES } outcome;

typedef struct {
    bool with; /* the causes */
    outcome outcome;
    mukca_status status;
    mukca_error error;
} answer;

typedef struct {
    const mukca_check *check;
    const mukca_diagnosed *result;
    mukca_diagnose_options options;
    mukca_replicate_task replicate;
    mukca_corrected arm;
    mukca_replicate_motion motions[MUKCA_MAX_CAUSES];
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
static void run_one(answer *out, check_task *task, mukca_diagnosis *d, int index)
{
    const int effects = task->arm.n_effects, motions = task->replicate.n_motions;
    mukca_dataset data;
    *out = (answer){.with = index % 2 == 0};
    if (!out->with) task->arm.n_effects = task->replicate.n_motions = 0;
    out->status =
        mukca_simulate_replicate(&data, &task->replicate, (uint64_t)index / 2 + 1, &out->error);
    task->arm.n_effects = effects, task->replicate.n_motions = motions;
    if (out->status != MUKCA_OK) return;
    out->status = mukca_diagnose(d, task->result->chain, &data, &task->options, &out->error);
    if (out->status == MUKCA_OK) out->outcome = judge(d, out->with ? task->check->cause : NULL);
    mukca_diagnosis_free(d);
    mukca_dataset_free(&data);
}

/* Recordings first, first + step, ...; without a cause, only those without. */
static void run_share(check_task *task, mukca_diagnosis *d, int pipe_end, int first, int step)
{
    const int by = task->check->cause ? 1 : 2;
    for (int i = first; i < 2 * task->check->runs / by; i += step) {
        answer out;
        run_one(&out, task, d, i * by + by - 1);
        if (write(pipe_end, &out, sizeof out) != sizeof out || out.status != MUKCA_OK) break;
    }
}

/* Count the outcomes until all recordings are diagnosed. */
static mukca_status collect(cli_call *call, mukca_check *check, int pipe_end)
{
    const int total = check->cause ? 2 * check->runs : check->runs;
    int *const count[OUTCOMES] = {&check->found, &check->tied, &check->other, &check->none};
    for (int done = 0; done < total;) {
        answer got;
        cli_progress(call, "diagnosing simulations", done, total);
        const ssize_t size = read(pipe_end, &got, sizeof got); /* 0: no process is left */
        if (cli_interrupted()) return MUKCA_INTERRUPTED;
        if (size < 0 && errno == EINTR) continue;
        if (size != sizeof got)
            return cli_fail(call, MUKCA_MEMORY,
                            "--check: a process ended early, after %d of %d recordings", done,
                            total);
        if (got.status != MUKCA_OK) {
            call->error = got.error;
            return got.status;
        }
        if (got.with)
            ++*count[got.outcome];
        else
            check->false_without += got.outcome != NONE;
        done++;
    }
    return MUKCA_OK;
}

static mukca_status run_all(cli_call *call, mukca_check *check, check_task *task,
                            mukca_diagnosis *scratch)
{
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    const int n = processors < 1                ? 1
                  : processors > MOST_PROCESSES ? MOST_PROCESSES
                                                : (int)processors;
    pid_t child[MOST_PROCESSES];
    int ends[2], started = 0;
    mukca_status status = MUKCA_OK;
    if (pipe(ends) != 0) return cli_fail(call, MUKCA_MEMORY, "--check: %s", strerror(errno));
    for (int k = 0; k < n && status == MUKCA_OK; k++) {
        child[k] = fork();
        if (child[k] == 0) {
            close(ends[0]);
            run_share(task, scratch, ends[1], k, n);
            _exit(0);
        }
        if (child[k] < 0)
            status = cli_fail(call, MUKCA_MEMORY, "--check: %s", strerror(errno));
        else
            started++;
    }
    close(ends[1]); /* reading then ends with the last process */
    if (status == MUKCA_OK) status = collect(call, check, ends[0]);
    close(ends[0]);
    for (int k = 0; k < started; k++) {
        if (status != MUKCA_OK) kill(child[k], SIGKILL);
        while (waitpid(child[k], NULL, 0) < 0 && errno == EINTR) continue;
    }
    return status;
}

/* Moved tools among the causes. */
static void find_motions(check_task *task)
{
    const mukca_diagnosis *d = task->result->diagnosis;
    for (int i = 0; i < d->n_causes; i++) {
        const mukca_cause *c = &d->causes[i];
        if (mukca_wording_on_arm(c)) continue;
        mukca_replicate_motion *m = &task->motions[task->replicate.n_motions++];
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
    task->arm.chain = *d->chain;
    task->arm.geometry = a->geometry;
    task->arm.n_effects = a->n_effects;
    memcpy(task->arm.effects, a->effects, sizeof *a->effects * (size_t)a->n_effects);
    for (int k = 0; k < task->arm.chain.n_elements; k++) { /* recorded angles can be outside */
        task->arm.chain.element[k].lower = -HUGE_VAL;
        task->arm.chain.element[k].upper = HUGE_VAL;
    }
    task->replicate = (mukca_replicate_task){.arm = &task->arm,
                                             .data = r->data,
                                             .posture = posture,
                                             .tracker = a->tracker,
                                             .noise = d->sigma_m,
                                             .rotation = d->sigma_rotation_rad,
                                             .correlation = d->rho,
                                             .shared = d->shared,
                                             .motions = task->motions};
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
    mukca_pool pool = {0};
    mukca_status status;
    check_task *task = MUKCA_TAKE(&pool, check_task, 1);
    mukca_diagnosis *scratch = MUKCA_TAKE(&pool, mukca_diagnosis, 1);
    d->check = (mukca_check){.runs = call->common->check, .cause = main_cause(&d->diagnosis)};
    if (task && scratch) {
        *task = (check_task){.check = &d->check, .result = &d->result, .options = d->options};
        task->options.test = NULL;
        task->options.no_folds = true;
        task->options.applied = task->options.mounting = false;
        task->options.go_on = NULL;
        task->options.progress = go_on;
    }
    if (task && scratch && prepare(task, &pool))
        status = run_all(call, &d->check, task, scratch);
    else
        status = cli_fail(call, MUKCA_MEMORY, "out of memory for --check");
    if (status == MUKCA_OK) d->result.check = &d->check;
    mukca_pool_free(&pool);
    return status;
}
