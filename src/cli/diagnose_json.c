/* The diagnosis as JSON (mukca.diagnose/1). */
#include <math.h>

#include "cli/diagnose.h"

static const char *placement_name(const mukca_dataset *data, int placement)
{
    return placement < 0 ? NULL : data->placements[placement].name;
}

static const char *socket_label(const mukca_dataset *data, int socket)
{
    return socket < 0 ? NULL : data->sockets[socket].label;
}

static json_t *shrink_object(const mukca_shrink *s)
{
    if (!isfinite(s->before_m)) return NULL;
    return cli_json("before_m:f after_m:f shrink_percent:f ci95:v folds_better:i folds:i",
                    s->before_m, s->after_m, s->shrink_percent, s->low_percent, s->high_percent,
                    s->folds_better, s->folds);
}

static json_t *sets_array(const mukca_diagnosed *r)
{
    json_t *sets = json_array();
    for (const mukca_cause_set *s = r->diagnosis->sets;
         s < r->diagnosis->sets + r->diagnosis->n_sets; s++) {
        json_t *causes = json_array();
        for (int i = 0; i < s->n; i++) {
            const mukca_effect *e = &s->member[i].effect;
            const bool listed = e->kind < MUKCA_EFFECT_COUNT, unknown = s->member[i].unknown;
            cli_json_append(causes, "effect:s joint:s order:n placement:s unknown:b row:n",
                            listed    ? mukca_effect_table[e->kind]->name
                            : unknown ? NULL
                                      : "outlier",
                            mukca_chain_joint_name(r->chain, e->joint),
                            e->kind == MUKCA_EFFECT_GEAR_HARMONIC ? e->variant.order : 0,
                            placement_name(r->data, listed ? e->placement : -1), unknown,
                            s->member[i].row);
        }
        cli_json_append(sets, "probability:f causes:o", s->probability, causes);
    }
    return sets;
}

static json_t *cause_object(const mukca_cause *c, const mukca_chain *chain,
                            const mukca_dataset *data)
{
    const mukca_effect_info *info = mukca_effect_table[c->effect.kind];
    json_t *ties = json_array();
    for (const mukca_tie *t = c->ties; t < c->ties + c->n_ties; t++)
        cli_json_append(ties, "effect:s joint:s order:n log_bayes_factor:f correlation:f",
                        mukca_effect_table[t->effect]->name,
                        mukca_chain_joint_name(chain, t->joint), t->rival.variant.order,
                        t->log_bayes_factor, t->correlation);
    return cli_json(
        "effect:s joint:s placement:s socket:s row:n order:n order_interval:o motion:s amplitude:f "
        "unit:s ci95:v log_bayes_factor:f probability:f ties:o or_unknown:b held_out:o",
        info->name, mukca_chain_joint_name(chain, c->effect.joint),
        placement_name(data, c->effect.placement), socket_label(data, c->socket), c->row,
        info->site == MUKCA_SITE_ANGLE ? c->effect.variant.order : 0,
        c->order_range[0] > 0 ? json_pack("[i, i]", c->order_range[0], c->order_range[1]) : NULL,
        info->site != MUKCA_SITE_SOCKET ? NULL
        : c->creep                      ? "creep"
                                        : "step",
        c->amplitude, mukca_effect_unit(&c->effect, chain), c->low, c->high, c->log_bayes_factor,
        c->probability, ties, c->or_unknown, shrink_object(&c->held_out));
}

static json_t *faults_array(const mukca_diagnosis *d, const mukca_dataset *data)
{
    json_t *array = json_array();
    for (const mukca_data_fault *f = d->faults; f < d->faults + d->n_faults; f++)
        cli_json_append(array, "kind:s placement:s socket:s row:i file:s size_m:f",
                        mukca_fault_name[f->kind], placement_name(data, f->placement),
                        socket_label(data, f->socket), f->row,
                        data->files ? data->files[f->file] : NULL, f->size_m);
    return array;
}

static json_t *placements_array(const double *mae, int n, const mukca_dataset *data)
{
    json_t *array = json_array();
    for (int p = 0; mae && p < n; p++)
        cli_json_append(array, "placement:s mae_m:f", data->placements[p].name, mae[p]);
    return array;
}

/* Next poses, q in the order of the chain's joints, rad or m, and the two causes that they
 * distinguish. */
static json_t *next_poses_array(const mukca_diagnosed *r)
{
    json_t *array = json_array();
    const mukca_next_poses *next = r->next;
    if (!next || next->cause < 0) return array;
    const mukca_cause *c = &r->diagnosis->causes[next->cause];
    const mukca_effect rivals[2] = {c->effect, c->ties[next->tie].rival};
    for (int i = 0; i < next->plan.n_rows; i++) {
        const mukca_plan_row *row = &next->plan.rows[i];
        json_t *pair = json_array();
        for (int k = 0; k < 2; k++)
            cli_json_append(pair, "effect:s joint:s", mukca_effect_table[rivals[k].kind]->name,
                            mukca_chain_joint_name(r->chain, rivals[k].joint));
        cli_json_append(array, "placement:s socket:s q:o tells_apart:o",
                        next->sockets[row->socket].placement, next->sockets[row->socket].label,
                        cli_json_reals(row->q, r->chain->n_joints), pair);
    }
    return array;
}

/* Several pose logs: the frames that differ between them. */
static json_t *logs_object(const mukca_logs *logs)
{
    const double *evidence = logs->log_evidence;
    if (logs->n < 2) return NULL;
    return cli_json(
        "count:i base_per_log:b tool_per_log:b log_evidence{shared:f base:f tool:f both:f}",
        logs->n, logs->base_per_log, logs->tool_per_log, evidence[0], evidence[1], evidence[2],
        evidence[3]);
}

/* Comparison of the two streams of angles, joint by joint. */
static json_t *streams_object(const mukca_streams *s, const mukca_diagnosed *r)
{
    if (s->n_joints == 0) return NULL;
    json_t *joints = json_array();
    for (int j = 0; j < s->n_joints; j++) {
        const mukca_stream *of = &s->joint[j];
        cli_json_append(joints, "joint:s rows:i mean:f rms:f servo_sag:f ci95:v log_bayes_factor:f",
                        mukca_chain_joint_name(r->chain, j), of->rows, of->mean, of->rms, of->sag,
                        of->low, of->high, of->log_bayes_factor);
    }
    return cli_json("fitted:s sigma_reading_m:f sigma_command_m:f joints:o",
                    r->data->by_command ? "command" : "reading", s->sigma_reading_m,
                    s->sigma_command_m, joints);
}

static json_t *test_object(const mukca_diagnosis *d, const mukca_dataset *test)
{
    if (!test) return NULL;
    return cli_json("nominal_m:f geometry_m:f explained_m:f placements:o", d->test_nominal_m,
                    d->test_geometry_m, d->test_explained_m,
                    placements_array(d->test_placement_mae_m, d->n_test_placements, test));
}

static json_t *check_object(const mukca_check *c)
{
    if (!c) return NULL;
    json_t *const none = NULL;
    json_t *object = cli_json("runs:i found:o tied:o other:o none:o false_without:i", c->runs, none,
                              none, none, none, c->false_without);
    if (c->cause)
        json_object_update_new(object, cli_json("found:i tied:i other:i none:i", c->found, c->tied,
                                                c->other, c->none));
    return object;
}

static json_t *causes_array(const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char words[MUKCA_WORDING];
    json_t *causes = json_array();
    for (int i = 0; i < d->n_causes; i++) {
        json_t *cause = cause_object(&d->causes[i], r->chain, r->data);
        mukca_wording_rivals(words, &d->causes[i], r);
        json_object_update_new(
            cause, cli_json("sentence:s cumulative_m:f remedy:s", words, d->causes[i].rung_m,
                            mukca_wording_remedy(&d->causes[i], r)));
        json_array_append_new(causes, cause);
    }
    return causes;
}

static json_t *where_object(const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    json_t *joints = json_array();
    for (int i = 0; i < d->n_where; i++)
        cli_json_append(joints, "joint:s share:f range_rad:o",
                        mukca_chain_joint_name(r->chain, d->where[i].joint), d->where[i].share,
                        cli_json_reals(d->where[i].range_rad, 2));
    return cli_json("joints:o placements:o axes:o", joints,
                    placements_array(d->placement_mae_m, r->data->n_placements, r->data),
                    cli_json_reals(d->axis_rms_m, 3));
}

static json_t *tested_array(const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    json_t *tested = json_array();
    for (const mukca_tested *t = d->tested; t < d->tested + d->n_tested; t++)
        cli_json_append(
            tested,
            "effect:s joint:s log_bayes_factor:f log_odds:f detection_limit:f testable:b why:s",
            mukca_effect_table[t->effect]->name, mukca_chain_joint_name(r->chain, t->joint),
            t->log_bayes_factor, t->log_odds, t->limit, t->testable, t->why);
    return tested;
}

json_t *cli_diagnosis_json(const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    const double *g = d->gravity;
    json_t *suspected = json_array(), *names = json_array();
    char caveat[MUKCA_WORDING], verdict[MUKCA_WORDING];
    for (int i = 0; i < d->n_suspected; i++)
        json_array_append_new(suspected, cause_object(&d->suspected[i], r->chain, r->data));
    for (int j = 0; j < r->chain->n_joints; j++)
        json_array_append_new(names, cli_json_text(mukca_chain_joint_name(r->chain, j)));
    mukca_wording_caveat(caveat, r);
    mukca_wording_verdict(verdict, r);
    json_t *root = cli_json(
        "schema:s verdict:s unexplained:b causes:o data_faults:o gap{nominal_m:f geometry_m:f "
        "faults_excused_m:f explained_m:f with_unknown_m:f surprise:f noise_floor_m:f folds:i "
        "held_out:o noise_shrink_percent:f} test:o where:o tested:o noise{sigma_m:f "
        "lag_one_correlation:f shared_by_posture:f} joints:o why:s sentence:s",
        "mukca.diagnose/1", mukca_verdict_name[d->verdict], d->unexplained, causes_array(r),
        faults_array(d, r->data), d->nominal_m, d->geometry_m, d->faults_excused_m, d->explained_m,
        d->structure_m, d->surprise, d->noise_floor_m, d->folds, shrink_object(&d->held_out),
        d->noise_shrink_percent, test_object(d, r->test), where_object(r), tested_array(r),
        d->sigma_m, d->rho, d->shared, names,
        d->why    ? d->why
        : *caveat ? caveat
                  : NULL,
        verdict);
    json_object_update_new(
        root,
        cli_json("suspected:o sets:o unexplained_log_bayes_factor:f unnamed_m:f gravity:o "
                 "efforts_correlation:f streams:o logs:o check:o next_poses:o elapsed_s:f",
                 suspected, sets_array(r), d->structure, d->explained_m - d->structure_m,
                 g[0] != 0 || g[1] != 0 || g[2] != 0 ? cli_json_reals(g, 3) : NULL,
                 d->efforts_correlation, streams_object(&d->streams, r), logs_object(&d->logs),
                 check_object(r->check), next_poses_array(r), d->elapsed_s));
    return root;
}
