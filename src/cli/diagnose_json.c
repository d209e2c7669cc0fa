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
    return cli_json(FIELD(s, before_m), FIELD(s, after_m), FIELD(s, shrink_percent),
                    KEY("ci95", cli_json_interval(s->low_percent, s->high_percent)),
                    FIELD(s, folds_better), FIELD(s, folds));
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
            cli_json_append(
                causes,
                KEY("effect", listed    ? mukca_effect_table[e->kind]->name
                              : unknown ? NULL
                                        : "outlier"),
                KEY("joint", mukca_chain_joint_name(r->chain, e->joint)),
                KEY("order", cli_json_positive(
                                 e->kind == MUKCA_EFFECT_GEAR_HARMONIC ? e->variant.order : 0)),
                KEY("placement", placement_name(r->data, listed ? e->placement : -1)),
                KEY("unknown", unknown), KEY("row", cli_json_positive(s->member[i].row)));
        }
        cli_json_append(sets, FIELD(s, probability), KEY("causes", causes));
    }
    return sets;
}

static json_t *cause_object(const mukca_cause *c, const mukca_chain *chain,
                            const mukca_dataset *data)
{
    const mukca_effect_info *info = mukca_effect_table[c->effect.kind];
    json_t *ties = json_array();
    for (const mukca_tie *t = c->ties; t < c->ties + c->n_ties; t++)
        cli_json_append(ties, KEY("effect", mukca_effect_table[t->effect]->name),
                        KEY("joint", mukca_chain_joint_name(chain, t->joint)),
                        KEY("order", cli_json_positive(t->rival.variant.order)),
                        FIELD(t, log_bayes_factor), FIELD(t, correlation));
    return cli_json(
        KEY("effect", info->name), KEY("joint", mukca_chain_joint_name(chain, c->effect.joint)),
        KEY("placement", placement_name(data, c->effect.placement)),
        KEY("socket", socket_label(data, c->socket)), KEY("row", cli_json_positive(c->row)),
        KEY("order",
            cli_json_positive(info->site == MUKCA_SITE_ANGLE ? c->effect.variant.order : 0)),
        KEY("order_interval", c->order_range[0] > 0
                                  ? json_pack("[i, i]", c->order_range[0], c->order_range[1])
                                  : NULL),
        KEY("motion", info->site != MUKCA_SITE_SOCKET ? NULL
                      : c->creep                      ? "creep"
                                                      : "step"),
        FIELD(c, amplitude), KEY("unit", mukca_effect_unit(&c->effect, chain)),
        KEY("ci95", cli_json_interval(c->low, c->high)), FIELD(c, log_bayes_factor),
        FIELD(c, probability), KEY("ties", ties), FIELD(c, or_unknown),
        KEY("held_out", shrink_object(&c->held_out)));
}

static json_t *faults_array(const mukca_diagnosis *d, const mukca_dataset *data)
{
    json_t *array = json_array();
    for (const mukca_data_fault *f = d->faults; f < d->faults + d->n_faults; f++)
        cli_json_append(array, KEY("kind", mukca_fault_name[f->kind]),
                        KEY("placement", placement_name(data, f->placement)),
                        KEY("socket", socket_label(data, f->socket)), FIELD(f, row),
                        KEY("file", data->files ? data->files[f->file] : NULL), FIELD(f, size_m));
    return array;
}

static json_t *placements_array(const double *mae, int n, const mukca_dataset *data)
{
    json_t *array = json_array();
    for (int p = 0; mae && p < n; p++)
        cli_json_append(array, KEY("placement", data->placements[p].name), KEY("mae_m", mae[p]));
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
            cli_json_append(pair, KEY("effect", mukca_effect_table[rivals[k].kind]->name),
                            KEY("joint", mukca_chain_joint_name(r->chain, rivals[k].joint)));
        cli_json_append(array, KEY("placement", next->sockets[row->socket].placement),
                        KEY("socket", next->sockets[row->socket].label),
                        KEY("q", cli_json_reals(row->q, r->chain->n_joints)),
                        KEY("tells_apart", pair));
    }
    return array;
}

/* Several pose logs: the frames that differ between them. */
static json_t *logs_object(const mukca_logs *logs)
{
    const double *evidence = logs->log_evidence;
    if (logs->n < 2) return NULL;
    return cli_json(
        KEY("count", logs->n), FIELD(logs, base_per_log), FIELD(logs, tool_per_log),
        KEY("log_evidence", cli_json(KEY("shared", evidence[0]), KEY("base", evidence[1]),
                                     KEY("tool", evidence[2]), KEY("both", evidence[3]))));
}

/* Comparison of the two streams of angles, joint by joint. */
static json_t *streams_object(const mukca_streams *s, const mukca_diagnosed *r)
{
    if (s->n_joints == 0) return NULL;
    json_t *joints = json_array();
    for (int j = 0; j < s->n_joints; j++) {
        const mukca_stream *of = &s->joint[j];
        cli_json_append(joints, KEY("joint", mukca_chain_joint_name(r->chain, j)), FIELD(of, rows),
                        FIELD(of, mean), FIELD(of, rms), KEY("servo_sag", of->sag),
                        KEY("ci95", cli_json_interval(of->low, of->high)),
                        FIELD(of, log_bayes_factor));
    }
    return cli_json(KEY("fitted", r->data->by_command ? "command" : "reading"),
                    FIELD(s, sigma_reading_m), FIELD(s, sigma_command_m), KEY("joints", joints));
}

static json_t *test_object(const mukca_diagnosis *d, const mukca_dataset *test)
{
    if (!test) return NULL;
    return cli_json(
        KEY("nominal_m", d->test_nominal_m), KEY("geometry_m", d->test_geometry_m),
        KEY("explained_m", d->test_applied_m),
        KEY("placements", placements_array(d->test_placement_mae_m, d->n_test_placements, test)));
}

static json_t *check_object(const mukca_check *c)
{
    if (!c) return NULL;
    json_t *counts[] = {NULL, NULL, NULL, NULL};
    const int of[] = {c->found, c->tied, c->other, c->none};
    for (int i = 0; i < 4 && c->cause; i++) counts[i] = json_integer(of[i]);
    return cli_json(FIELD(c, runs), KEY("found", counts[0]), KEY("tied", counts[1]),
                    KEY("other", counts[2]), KEY("none", counts[3]), FIELD(c, false_without));
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
            cause, cli_json(KEY("sentence", words), KEY("cumulative_m", d->causes[i].rung_m),
                            KEY("remedy", mukca_wording_remedy(&d->causes[i], r))));
        json_array_append_new(causes, cause);
    }
    return causes;
}

static json_t *where_object(const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    json_t *joints = json_array();
    for (int i = 0; i < d->n_where; i++)
        cli_json_append(joints, KEY("joint", mukca_chain_joint_name(r->chain, d->where[i].joint)),
                        KEY("share", d->where[i].share),
                        KEY("range_rad", cli_json_reals(d->where[i].range_rad, 2)));
    return cli_json(
        KEY("joints", joints),
        KEY("placements", placements_array(d->placement_mae_m, r->data->n_placements, r->data)),
        KEY("axes", cli_json_reals(d->axis_rms_m, 3)));
}

static json_t *tested_array(const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    json_t *tested = json_array();
    for (const mukca_tested *t = d->tested; t < d->tested + d->n_tested; t++)
        cli_json_append(tested, KEY("effect", mukca_effect_table[t->effect]->name),
                        KEY("joint", mukca_chain_joint_name(r->chain, t->joint)),
                        FIELD(t, log_bayes_factor), FIELD(t, log_odds),
                        KEY("detection_limit", t->limit), FIELD(t, testable), FIELD(t, why));
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
    return cli_json(
        KEY("schema", "mukca.diagnose/1"), KEY("verdict", mukca_verdict_name[d->verdict]),
        FIELD(d, unexplained), KEY("causes", causes_array(r)),
        KEY("data_faults", faults_array(d, r->data)),
        KEY("gap",
            cli_json(FIELD(d, nominal_m), FIELD(d, geometry_m), FIELD(d, faults_excused_m),
                     KEY("explained_m", d->applied_m), KEY("with_unknown_m", d->structure_m),
                     FIELD(d, surprise), FIELD(d, noise_floor_m), FIELD(d, folds),
                     KEY("held_out", shrink_object(&d->held_out)), FIELD(d, noise_shrink_percent))),
        KEY("test", test_object(d, r->test)), KEY("where", where_object(r)),
        KEY("tested", tested_array(r)),
        KEY("noise", cli_json(FIELD(d, sigma_m), KEY("lag_one_correlation", d->rho),
                              KEY("shared_by_posture", d->shared))),
        KEY("joints", names),
        KEY("why", d->why    ? d->why
                   : *caveat ? caveat
                             : NULL),
        KEY("sentence", verdict), KEY("suspected", suspected), KEY("sets", sets_array(r)),
        KEY("unexplained_log_bayes_factor", d->structure),
        KEY("unnamed_m", d->applied_m - d->structure_m),
        KEY("gravity", g[0] != 0 || g[1] != 0 || g[2] != 0 ? cli_json_reals(g, 3) : NULL),
        FIELD(d, efforts_correlation), KEY("streams", streams_object(&d->streams, r)),
        KEY("logs", logs_object(&d->logs)), KEY("check", check_object(r->check)),
        KEY("next_poses", next_poses_array(r)), FIELD(d, elapsed_s));
}
