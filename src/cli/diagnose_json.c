/* The diagnosis as JSON (mukca.diagnose/1). */
#include <math.h>

#include "cli/diagnose.h"

static json_t *joint_name(const mukca_chain *chain, int joint)
{
    return cli_json_text(mukca_chain_joint_name(chain, joint));
}

static json_t *placement_name(const mukca_dataset *data, int placement)
{
    return placement < 0 ? json_null() : json_string(data->placements[placement].name);
}

static json_t *socket_label(const mukca_dataset *data, int socket)
{
    return socket < 0 ? json_null() : json_string(data->sockets[socket].label);
}

static json_t *interval(double low, double high)
{
    const double both[2] = {low, high};
    return isfinite(low) && isfinite(high) ? cli_json_reals(both, 2) : json_null();
}

static json_t *shrink_object(const mukca_shrink *s)
{
    if (!isfinite(s->before_m)) return json_null();
    return json_pack("{s:o, s:o, s:o, s:o, s:i, s:i}", "before_m", cli_json_real(s->before_m),
                     "after_m", cli_json_real(s->after_m), "shrink_percent",
                     cli_json_real(s->shrink_percent), "ci95",
                     interval(s->low_percent, s->high_percent), "folds_better", s->folds_better,
                     "folds", s->folds);
}

static json_t *sets_array(const mukca_diagnosed *r)
{
    json_t *sets = json_array();
    for (const mukca_cause_set *s = r->diagnosis->sets;
         s < r->diagnosis->sets + r->diagnosis->n_sets; s++) {
        json_t *causes = json_array();
        for (int i = 0; i < s->n; i++) {
            const mukca_effect *e = &s->member[i].effect;
            const bool listed = e->kind < MUKCA_EFFECT_COUNT;
            json_array_append_new(
                causes,
                json_pack("{s:o, s:o, s:o, s:o, s:b, s:o}", "effect",
                          cli_json_text(listed                 ? mukca_effect_table[e->kind]->name
                                        : s->member[i].unknown ? NULL
                                                               : "outlier"),
                          "joint", joint_name(r->chain, e->joint), "order",
                          e->kind == MUKCA_EFFECT_GEAR_HARMONIC ? json_integer(e->variant.order)
                                                                : json_null(),
                          "placement", placement_name(r->data, listed ? e->placement : -1),
                          "unknown", s->member[i].unknown, "row",
                          s->member[i].row > 0 ? json_integer(s->member[i].row) : json_null()));
        }
        json_array_append_new(sets, json_pack("{s:o, s:o}", "probability",
                                              cli_json_real(s->probability), "causes", causes));
    }
    return sets;
}

static json_t *cause_object(const mukca_cause *c, const mukca_chain *chain,
                            const mukca_dataset *data)
{
    json_t *ties = json_array();
    for (int i = 0; i < c->n_ties; i++) {
        const mukca_tie *t = &c->ties[i];
        json_array_append_new(
            ties, json_pack("{s:s, s:o, s:o, s:o}", "effect", mukca_effect_table[t->effect]->name,
                            "joint", joint_name(chain, t->joint), "log_bayes_factor",
                            cli_json_real(t->log_bayes_factor), "correlation",
                            cli_json_real(t->correlation)));
    }
    const mukca_effect_info *info = mukca_effect_table[c->effect.kind];
    return json_pack(
        "{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:s, s:o, s:o, s:o, s:o, s:b, s:o}",
        "effect", info->name, "joint", joint_name(chain, c->effect.joint), "placement",
        placement_name(data, c->effect.placement), "socket", socket_label(data, c->socket), "row",
        c->row > 0 ? json_integer(c->row) : json_null(), "order",
        info->site == MUKCA_SITE_ANGLE && c->effect.variant.order
            ? json_integer(c->effect.variant.order)
            : json_null(),
        "order_interval",
        c->order_range[0] > 0 ? json_pack("[i, i]", c->order_range[0], c->order_range[1])
                              : json_null(),
        "motion",
        info->site == MUKCA_SITE_SOCKET ? json_string(c->creep ? "creep" : "step") : json_null(),
        "amplitude", cli_json_real(c->amplitude), "unit", mukca_effect_unit(&c->effect, chain),
        "ci95", interval(c->low, c->high), "log_bayes_factor", cli_json_real(c->log_bayes_factor),
        "probability", cli_json_real(c->probability), "ties", ties, "or_unknown", c->or_unknown,
        "held_out", shrink_object(&c->held_out));
}

static json_t *fault_object(const mukca_data_fault *f, const mukca_dataset *data)
{
    return json_pack("{s:s, s:o, s:o, s:i, s:o, s:o}", "kind", mukca_fault_name[f->kind],
                     "placement", placement_name(data, f->placement), "socket",
                     socket_label(data, f->socket), "row", f->row, "file",
                     cli_json_text(data->files ? data->files[f->file] : NULL), "size_m",
                     cli_json_real(f->size_m));
}

static json_t *placements_array(const double *mae, int n, const mukca_dataset *data)
{
    json_t *array = json_array();
    for (int p = 0; mae && p < n; p++)
        json_array_append_new(array, json_pack("{s:s, s:o}", "placement", data->placements[p].name,
                                               "mae_m", cli_json_real(mae[p])));
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
            json_array_append_new(
                pair, json_pack("{s:s, s:o}", "effect", mukca_effect_table[rivals[k].kind]->name,
                                "joint", joint_name(r->chain, rivals[k].joint)));
        json_array_append_new(
            array,
            json_pack("{s:s, s:s, s:o, s:o}", "placement", next->sockets[row->socket].placement,
                      "socket", next->sockets[row->socket].label, "q",
                      cli_json_reals(row->q, r->chain->n_joints), "tells_apart", pair));
    }
    return array;
}

/* Several pose logs: the frames that differ between them. */
static json_t *logs_object(const mukca_logs *logs)
{
    static const char *const cases[] = {"shared", "base", "tool", "both"};
    if (logs->n < 2) return json_null();
    json_t *evidence = json_object();
    for (int i = 0; i < 4; i++)
        json_object_set_new(evidence, cases[i], cli_json_real(logs->log_evidence[i]));
    return json_pack("{s:i, s:b, s:b, s:o}", "count", logs->n, "base_per_log", logs->base_per_log,
                     "tool_per_log", logs->tool_per_log, "log_evidence", evidence);
}

/* Comparison of the two streams of angles, joint by joint. */
static json_t *streams_object(const mukca_streams *s, const mukca_diagnosed *r)
{
    if (s->n_joints == 0) return json_null();
    json_t *joints = json_array();
    for (int j = 0; j < s->n_joints; j++) {
        const mukca_stream *of = &s->joint[j];
        json_array_append_new(
            joints, json_pack("{s:o, s:i, s:o, s:o, s:o, s:o, s:o}", "joint",
                              joint_name(r->chain, j), "rows", of->rows, "mean",
                              cli_json_real(of->mean), "rms", cli_json_real(of->rms), "servo_sag",
                              cli_json_real(of->sag), "ci95", interval(of->low, of->high),
                              "log_bayes_factor", cli_json_real(of->log_bayes_factor)));
    }
    return json_pack("{s:s, s:o, s:o, s:o}", "fitted", r->data->by_command ? "command" : "reading",
                     "sigma_reading_m", cli_json_real(s->sigma_reading_m), "sigma_command_m",
                     cli_json_real(s->sigma_command_m), "joints", joints);
}

static json_t *gap_object(const mukca_diagnosis *d)
{
    json_t *gap = cli_json_numbers("nominal_m", d->nominal_m, "geometry_m", d->geometry_m,
                                   "faults_excused_m", d->faults_excused_m, "explained_m",
                                   d->explained_m, "with_unknown_m", d->structure_m, "surprise",
                                   d->surprise, "noise_floor_m", d->noise_floor_m);
    json_object_set_new(gap, "folds", json_integer(d->folds));
    json_object_set_new(gap, "held_out", shrink_object(&d->held_out));
    json_object_set_new(gap, "noise_shrink_percent", cli_json_real(d->noise_shrink_percent));
    return gap;
}

static json_t *test_object(const mukca_diagnosis *d, const mukca_dataset *test)
{
    json_t *object = cli_json_numbers("nominal_m", d->test_nominal_m, "geometry_m",
                                      d->test_geometry_m, "explained_m", d->test_explained_m);
    json_object_set_new(object, "placements",
                        placements_array(d->test_placement_mae_m, d->n_test_placements, test));
    return object;
}

static json_t *check_object(const mukca_check *c)
{
    if (!c) return json_null();
    return c->cause ? json_pack("{s:i, s:i, s:i, s:i, s:i, s:i}", "runs", c->runs, "found",
                                c->found, "tied", c->tied, "other", c->other, "none", c->none,
                                "false_without", c->false_without)
                    : json_pack("{s:i, s:n, s:n, s:n, s:n, s:i}", "runs", c->runs, "found", "tied",
                                "other", "none", "false_without", c->false_without);
}

json_t *cli_diagnosis_json(const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    const mukca_chain *chain = r->chain;
    const mukca_dataset *data = r->data;
    json_t *causes = json_array(), *suspected = json_array(), *faults = json_array(),
           *tested = json_array(), *joints = json_array();
    char words[MUKCA_WORDING];
    for (int i = 0; i < d->n_causes; i++) {
        json_t *cause = cause_object(&d->causes[i], chain, data);
        mukca_wording_rivals(words, &d->causes[i], r);
        json_object_set_new(cause, "sentence", cli_json_text(words));
        json_object_set_new(cause, "cumulative_m", cli_json_real(d->causes[i].rung_m));
        json_object_set_new(cause, "remedy", json_string(mukca_wording_remedy(&d->causes[i], r)));
        json_array_append_new(causes, cause);
    }
    for (int i = 0; i < d->n_suspected; i++)
        json_array_append_new(suspected, cause_object(&d->suspected[i], chain, data));
    for (int i = 0; i < d->n_faults; i++)
        json_array_append_new(faults, fault_object(&d->faults[i], data));
    for (int i = 0; i < d->n_where; i++)
        json_array_append_new(
            joints, json_pack("{s:o, s:o, s:o}", "joint", joint_name(chain, d->where[i].joint),
                              "share", cli_json_real(d->where[i].share), "range_rad",
                              cli_json_reals(d->where[i].range_rad, 2)));
    for (int i = 0; i < d->n_tested; i++) {
        const mukca_tested *t = &d->tested[i];
        json_array_append_new(
            tested,
            json_pack("{s:s, s:o, s:o, s:o, s:o, s:b, s:o}", "effect",
                      mukca_effect_table[t->effect]->name, "joint", joint_name(chain, t->joint),
                      "log_bayes_factor", cli_json_real(t->log_bayes_factor), "log_odds",
                      cli_json_real(t->log_odds), "detection_limit", cli_json_real(t->limit),
                      "testable", t->testable, "why", cli_json_text(t->why)));
    }
    json_t *root = json_pack("{s:s, s:s, s:b, s:o, s:o}", "schema", "mukca.diagnose/1", "verdict",
                             mukca_verdict_name[d->verdict], "unexplained", d->unexplained,
                             "causes", causes, "data_faults", faults);
    json_object_set_new(root, "gap", gap_object(d));
    json_object_set_new(root, "test", r->test ? test_object(d, r->test) : json_null());
    json_object_set_new(root, "where",
                        json_pack("{s:o, s:o, s:o}", "joints", joints, "placements",
                                  placements_array(d->placement_mae_m, data->n_placements, data),
                                  "axes", cli_json_reals(d->axis_rms_m, 3)));
    json_object_set_new(root, "tested", tested);
    json_object_set_new(root, "noise",
                        cli_json_numbers("sigma_m", d->sigma_m, "lag_one_correlation", d->rho,
                                         "shared_by_posture", d->shared));
    json_t *names = json_array();
    for (int j = 0; j < chain->n_joints; j++) json_array_append_new(names, joint_name(chain, j));
    json_object_set_new(root, "joints", names);
    mukca_wording_caveat(words, r);
    json_object_set_new(root, "why", cli_json_text(d->why ? d->why : *words ? words : NULL));
    mukca_wording_verdict(words, r);
    json_object_set_new(root, "sentence", cli_json_text(words));
    json_object_set_new(root, "suspected", suspected);
    json_object_set_new(root, "sets", sets_array(r));
    json_object_set_new(root, "unexplained_log_bayes_factor",
                        cli_json_real(d->structure > -HUGE_VAL ? d->structure : (double)NAN));
    json_object_set_new(root, "unnamed_m", cli_json_real(d->explained_m - d->structure_m));
    json_object_set_new(root, "gravity",
                        d->gravity[0] != 0 || d->gravity[1] != 0 || d->gravity[2] != 0
                            ? cli_json_reals(d->gravity, 3)
                            : json_null());
    json_object_set_new(root, "efforts_correlation", cli_json_real(d->efforts_correlation));
    json_object_set_new(root, "streams", streams_object(&d->streams, r));
    json_object_set_new(root, "logs", logs_object(&d->logs));
    json_object_set_new(root, "check", check_object(r->check));
    json_object_set_new(root, "next_poses", next_poses_array(r));
    json_object_set_new(root, "elapsed_s", cli_json_real(d->elapsed_s));
    return root;
}
