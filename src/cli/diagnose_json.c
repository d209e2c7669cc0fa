/* The diagnosis as JSON (mukca.diagnose/1). */
#include <math.h>

#include "cli/diagnose.h"

/* Members that many objects have. */
#define EFFECT(kind) KEY("effect", mukca_effect_table[kind]->name)
#define JOINT(number) KEY("joint", mukca_chain_joint_name(r->chain, number))
#define PLACEMENT(number) KEY("placement", (number) < 0 ? NULL : r->data->placements[number].name)
#define SOCKET(number) KEY("socket", (number) < 0 ? NULL : r->data->sockets[number].label)

/* Placement of an effect, -1: none; of two placements that differ, neither is the one that changed.
 */
static int placement_of(const mukca_diagnosed *r, const mukca_effect *e)
{
    const bool apart = mukca_effect_has((int)e->kind, MUKCA_TRAIT_PER_PLACEMENT) &&
                       !mukca_effect_has((int)e->kind, MUKCA_TRAIT_RECORDING_FAULT);
    return apart && r->data->n_placements == 2 ? -1 : e->placement;
}

/* An array of the objects of items[n]. */
#define LIST(items, n, object) list(r, items, n, sizeof *(items), object)
static json_t *list(const mukca_diagnosed *r, const void *items, int n, size_t size,
                    json_t *(*object)(const mukca_diagnosed *r, const void *item))
{
    json_t *array = json_array();
    const char *item = items;
    for (int i = 0; i < n; i++, item += size) json_array_append_new(array, object(r, item));
    return array;
}

static json_t *shrink_json(const mukca_shrink *s)
{
    if (!isfinite(s->before_m)) return NULL;
    return cli_json(FIELD(s, before_m), FIELD(s, after_m), FIELD(s, shrink_percent),
                    KEY("ci95", cli_json_interval(s->low_percent, s->high_percent)),
                    FIELD(s, folds_better), FIELD(s, folds));
}

static json_t *set_json(const mukca_diagnosed *r, const void *item)
{
    const mukca_cause_set *s = item;
    json_t *causes = json_array();
    for (int k = 0; k < s->n; k++) {
        const mukca_effect *e = &s->member[k].effect;
        const bool listed = e->kind < MUKCA_EFFECT_COUNT, unknown = s->member[k].unknown;
        const bool ordered = mukca_effect_has((int)e->kind, MUKCA_TRAIT_ORDERS);
        cli_json_append(causes,
                        KEY("effect", listed    ? mukca_effect_table[e->kind]->name
                                      : unknown ? NULL
                                                : "outlier"),
                        JOINT(e->joint),
                        KEY("order", cli_json_positive(ordered ? e->variant.order : 0)),
                        PLACEMENT(listed ? placement_of(r, e) : -1), KEY("unknown", unknown),
                        KEY("row", cli_json_positive(s->member[k].row)));
    }
    return cli_json(FIELD(s, probability), KEY("causes", causes));
}

static json_t *cause_json(const mukca_diagnosed *r, const void *item)
{
    const mukca_cause *c = item;
    const mukca_effect_site site = mukca_effect_table[c->effect.kind]->site;
    const int *range = c->order_range;
    json_t *ties = json_array();
    for (const mukca_tie *t = c->ties; t < c->ties + c->n_ties; t++)
        cli_json_append(ties, EFFECT(t->effect), JOINT(t->joint),
                        KEY("order", cli_json_positive(t->rival.variant.order)),
                        FIELD(t, log_bayes_factor), KEY("correlation", (double)NAN));
    return cli_json(
        EFFECT(c->effect.kind), JOINT(c->effect.joint), PLACEMENT(placement_of(r, &c->effect)),
        SOCKET(c->socket), KEY("row", cli_json_positive(c->row)),
        KEY("order", cli_json_positive(site == MUKCA_SITE_ANGLE ? c->effect.variant.order : 0)),
        KEY("order_interval", range[0] > 0 ? json_pack("[i, i]", range[0], range[1]) : NULL),
        KEY("motion", site != MUKCA_SITE_SOCKET ? NULL
                      : c->creep                ? "creep"
                                                : "step"),
        FIELD(c, amplitude), KEY("unit", mukca_effect_unit(&c->effect, r->chain)),
        KEY("ci95", cli_json_interval(c->low, c->high)), FIELD(c, log_bayes_factor),
        FIELD(c, probability), KEY("ties", ties), FIELD(c, or_unknown),
        KEY("held_out", shrink_json(&c->held_out)), KEY("cumulative_m", c->rung_m),
        KEY("remedy", mukca_wording_remedy(c, r)));
}

static json_t *alternative_json(const mukca_diagnosed *r, const void *item)
{
    const mukca_alternative *a = item;
    const bool ordered = mukca_effect_has((int)a->effect.kind, MUKCA_TRAIT_ORDERS);
    const int joint = a->listed ? a->effect.joint : a->from == a->to ? a->from : -1;
    return cli_json(KEY("effect", a->listed ? mukca_effect_table[a->effect.kind]->name : NULL),
                    KEY("varies_with", mukca_varies_name[a->family]),
                    JOINT(joint < r->chain->n_joints ? joint : -1),
                    PLACEMENT(a->listed ? placement_of(r, &a->effect) : -1),
                    KEY("order", cli_json_positive(ordered ? a->effect.variant.order : 0)),
                    KEY("from", mukca_wording_position(r, a->from)),
                    KEY("to", mukca_wording_position(r, a->to)), FIELD(a, probability),
                    KEY("amplitude", a->amplitude.value),
                    KEY("unit", a->listed ? mukca_effect_unit(&a->effect, r->chain) : NULL),
                    KEY("ci95", cli_json_estimate(&a->amplitude)));
}

static json_t *coefficient_json(const mukca_diagnosed *r, const mukca_finding *f)
{
    if (!isfinite(f->coefficient.value)) return NULL;
    return cli_json(KEY("value", f->coefficient.value),
                    KEY("unit", mukca_effect_unit(&f->quantity, r->chain)),
                    KEY("ci95", cli_json_estimate(&f->coefficient)));
}

static json_t *finding_json(const mukca_diagnosed *r, const void *item)
{
    const mukca_finding *f = item;
    static const char *const kinds[] = {"effect", "effect", "family", "tie", "place"};
    const mukca_finding_group *g = &f->group;
    const int at[2] = {g->apart ? r->chain->n_joints : g->from,
                       g->apart ? r->chain->n_joints : g->to};
    return cli_json(
        KEY("kind", kinds[g->kind]),
        KEY("effect", g->effect < 0 ? NULL : mukca_effect_table[g->effect]->name),
        KEY("varies_with", g->family < 0 ? NULL : mukca_varies_name[g->family]),
        KEY("from", mukca_wording_position(r, at[0])), KEY("to", mukca_wording_position(r, at[1])),
        PLACEMENT(mukca_wording_finding_placement(f)),
        KEY("order", cli_json_positive(f->order[0] ? f->alternatives[0].effect.variant.order : 0)),
        KEY("order_ci95", f->order[0] > 0 ? json_pack("[i, i]", f->order[0], f->order[1]) : NULL),
        KEY("probability", g->probability), KEY("halves", g->halves),
        KEY("halves_against", g->against), KEY("beside_finer", g->n_finer > 0),
        FIELD(g, beside_unknown), KEY("size_m", f->size_m.value),
        KEY("size_ci95_m", cli_json_estimate(&f->size_m)), FIELD(f, share),
        KEY("held_out", shrink_json(&f->held_out)), KEY("coefficient", coefficient_json(r, f)),
        KEY("alternatives", LIST(f->alternatives, f->n_alternatives, alternative_json)),
        KEY("sentence", mukca_wording_finding(MUKCA_WORDS, f, r)));
}

static json_t *fault_json(const mukca_diagnosed *r, const void *item)
{
    const mukca_data_fault *f = item;
    return cli_json(KEY("kind", mukca_fault_name[f->kind]), PLACEMENT(f->placement),
                    SOCKET(f->socket), FIELD(f, row),
                    KEY("file", r->data->files ? r->data->files[f->file] : NULL), FIELD(f, size_m));
}

static json_t *tested_json(const mukca_diagnosed *r, const void *item)
{
    const mukca_tested *t = item;
    return cli_json(EFFECT(t->effect), JOINT(t->joint), FIELD(t, log_bayes_factor),
                    FIELD(t, log_odds), KEY("detection_limit", t->limit), FIELD(t, testable),
                    FIELD(t, why));
}

static json_t *where_json(const mukca_diagnosed *r, const void *item)
{
    const mukca_where *w = item;
    return cli_json(JOINT(w->joint), FIELD(w, share),
                    KEY("range_rad", cli_json_reals(w->range_rad, 2)));
}

static json_t *placements_json(const double *mae, int n, const mukca_dataset *data)
{
    json_t *array = json_array();
    for (int p = 0; mae && p < n; p++)
        cli_json_append(array, KEY("placement", data->placements[p].name), KEY("mae_m", mae[p]));
    return array;
}

/* A posture, q in the order of the chain's joints, rad or m, and the two causes that it
 * distinguishes. */
static json_t *next_pose_json(const mukca_diagnosed *r, const void *item)
{
    const mukca_next_poses *next = r->next;
    const mukca_plan_row *row = item;
    const mukca_alternative *a = r->diagnosis->findings[next->finding].alternatives;
    json_t *pair = json_array();
    for (int k = 0; k < 2; k++)
        cli_json_append(pair, EFFECT(a[next->pair[k]].effect.kind),
                        JOINT(a[next->pair[k]].effect.joint));
    return cli_json(KEY("placement", next->sockets[row->socket].placement),
                    KEY("socket", next->sockets[row->socket].label),
                    KEY("q", cli_json_reals(row->q, r->chain->n_joints)), KEY("tells_apart", pair));
}

/* Several pose logs: the frames that differ between them. */
static json_t *logs_json(const mukca_logs *logs)
{
    const double *evidence = logs->log_evidence;
    if (logs->n < 2) return NULL;
    return cli_json(
        KEY("count", logs->n), FIELD(logs, base_per_log), FIELD(logs, tool_per_log),
        KEY("log_evidence", cli_json(KEY("shared", evidence[0]), KEY("base", evidence[1]),
                                     KEY("tool", evidence[2]), KEY("both", evidence[3]))));
}

/* Comparison of the two streams of angles at a joint. */
static json_t *stream_json(const mukca_diagnosed *r, const void *item)
{
    const mukca_stream_difference *difference = item;
    return cli_json(JOINT((int)(difference - r->diagnosis->streams.joint)), FIELD(difference, rows),
                    FIELD(difference, mean), FIELD(difference, rms),
                    KEY("servo_sag", difference->sag),
                    KEY("ci95", cli_json_interval(difference->low, difference->high)),
                    FIELD(difference, log_bayes_factor));
}

json_t *cli_diagnosis_json(const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    const mukca_streams *s = &d->streams;
    const mukca_next_poses *next = r->next;
    const char *caveat = mukca_wording_caveat(MUKCA_WORDS, r);
    json_t *names = json_array(), *test = NULL, *streams = NULL;
    for (int j = 0; j < r->chain->n_joints; j++)
        json_array_append_new(names, cli_json_text(mukca_chain_joint_name(r->chain, j)));
    if (r->test)
        test = cli_json(KEY("nominal_m", d->test_nominal_m), KEY("geometry_m", d->test_geometry_m),
                        KEY("explained_m", d->test_applied_m),
                        KEY("placements", placements_json(d->test_placement_mae_m,
                                                          d->n_test_placements, r->test)));
    if (s->n_joints)
        streams = cli_json(KEY("fitted", r->data->by_command ? "command" : "reading"),
                           FIELD(s, sigma_reading_m), FIELD(s, sigma_command_m),
                           KEY("joints", LIST(s->joint, s->n_joints, stream_json)));
    return cli_json(
        KEY("verdict", mukca_verdict_name[d->verdict]), FIELD(d, unexplained),
        KEY("causes", LIST(d->causes, d->n_causes, cause_json)),
        KEY("data_faults", LIST(d->faults, d->n_faults, fault_json)),
        KEY("gap", cli_json(FIELD(d, nominal_m), FIELD(d, geometry_m), FIELD(d, faults_excused_m),
                            KEY("explained_m", d->applied_m), KEY("with_unknown_m", d->structure_m),
                            FIELD(d, noise_floor_m), FIELD(d, folds),
                            KEY("held_out", shrink_json(&d->held_out)))),
        KEY("test", test),
        KEY("where", cli_json(KEY("joints", LIST(d->where, d->n_where, where_json)),
                              KEY("placements", placements_json(d->placement_mae_m,
                                                                r->data->n_placements, r->data)),
                              KEY("axes", cli_json_reals(d->axis_rms_m, 3)))),
        KEY("tested", LIST(d->tested, d->n_tested, tested_json)),
        KEY("noise", cli_json(FIELD(d, sigma_m), KEY("lag_one_correlation", d->rho),
                              KEY("shared_by_posture", d->shared))),
        KEY("joints", names),
        KEY("why", d->why    ? d->why
                   : *caveat ? caveat
                             : NULL),
        KEY("sentence", mukca_wording_verdict(MUKCA_WORDS, r)),
        KEY("findings", LIST(d->findings, d->n_findings, finding_json)),
        KEY("maybe", LIST(d->maybe, d->n_maybe, finding_json)),
        KEY("suspected", LIST(d->suspected, d->n_suspected, cause_json)),
        KEY("sets", LIST(d->sets, d->n_sets, set_json)),
        KEY("unexplained_log_bayes_factor", d->structure),
        KEY("unnamed_m", d->applied_m - d->structure_m), FIELD(d, efforts_correlation),
        KEY("efforts_turned", d->turned_efforts), KEY("streams", streams),
        KEY("logs", logs_json(&d->logs)),
        KEY("next_poses", LIST(next ? next->plan.rows : NULL,
                               next && next->finding >= 0 ? next->plan.n_rows : 0, next_pose_json)),
        FIELD(d, elapsed_s));
}

json_t *cli_adoption_json(const mukca_adoption *a, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    json_t *elastic = json_array(), *orders = json_array();
    for (int i = 0; i < a->n; i++) {
        const mukca_inherited *c = &a->list[i];
        const mukca_trait *t = c->trait;
        cli_json_append(elastic, EFFECT(t->effect.kind), JOINT(t->effect.joint), FIELD(c, value),
                        KEY("ci95", cli_json_interval(c->low, c->high)), FIELD(t, mean),
                        FIELD(t, spread), FIELD(t, probability), FIELD(c, own_share));
    }
    for (int i = 0; i < a->traits->n; i++) {
        const mukca_effect *e = &a->traits->list[i].effect;
        if (!mukca_effect_has((int)e->kind, MUKCA_TRAIT_ORDERS)) continue;
        cli_json_append(orders, JOINT(e->joint), KEY("order", e->variant.order),
                        KEY("probability", a->traits->list[i].probability));
    }
    return cli_json(KEY("log_bayes_factor", a->log_evidence), KEY("explained_m", d->applied_m),
                    KEY("without_m", d->explained_m), KEY("test_explained_m", d->test_applied_m),
                    KEY("test_without_m", d->test_explained_m), KEY("used", a->adopted),
                    FIELD(a, only), KEY("arms", a->traits->n_arms), KEY("effects", elastic),
                    KEY("orders", orders));
}
