/* mukca motion: JSON and table. */
#include <math.h>

#include "cli/motion.h"
#include "io/export.h"
#include "math/stats.h"
#include "mukca/version.h"

static json_t *alternatives(const mukca_motion_finding *f, const mukca_chain *chain)
{
    json_t *array = json_array();
    const int last = chain->n_joints - 1;
    for (int i = 0; i < f->n_alternatives; i++) {
        const mukca_motion_alternative *a = &f->alternative[i];
        const mukca_torque_effect *row = a->effect < 0 ? NULL : &mukca_torque_table[a->effect];
        const bool links = row ? row->links : mukca_wording_torque_on_links(&f->group);
        cli_json_append(
            array, KEY("effect", row ? row->name : NULL), KEY("on", links ? "links" : "joints"),
            KEY("from", mukca_wording_torque_position(chain, links, a->all ? 0 : a->from)),
            KEY("to", mukca_wording_torque_position(chain, links, a->all ? last : a->to)),
            KEY("joint", a->all || a->from < a->to ? NULL : mukca_chain_joint_name(chain, a->to)),
            KEY("order", cli_json_positive(a->detail)), FIELD(a, probability),
            KEY("amplitude", row ? a->amplitude.value : (double)NAN),
            KEY("unit", row ? row->unit : NULL),
            KEY("ci95", row ? cli_json_estimate(&a->amplitude) : NULL));
    }
    return array;
}

static json_t *finding(const mukca_motion_finding *f, const mukca_chain *chain)
{
    static const char *const kinds[] = {"effect", "effect", "family", "tie", "place"};
    const mukca_finding_group *g = &f->group;
    const bool links = mukca_wording_torque_on_links(g), sized = isfinite(f->coefficient.value);
    const double shrink = 100 * (1 - f->after_nm / f->before_nm);
    const int last = chain->n_joints - 1;
    return cli_json(
        KEY("kind", kinds[g->kind]),
        KEY("effect", g->effect < 0 ? NULL : mukca_torque_table[g->effect].name),
        KEY("varies_with", g->family < 0 ? NULL : mukca_torque_family_name[g->family]),
        KEY("on", links ? "links" : "joints"),
        KEY("from", mukca_wording_torque_position(chain, links, g->apart ? 0 : g->from)),
        KEY("to", mukca_wording_torque_position(chain, links, g->apart ? last : g->to)),
        KEY("order", cli_json_positive(f->order[0] ? f->alternative[0].detail : 0)),
        KEY("order_ci95", f->order[0] > 0 ? json_pack("[i, i]", f->order[0], f->order[1]) : NULL),
        KEY("probability", g->probability), KEY("halves", g->halves),
        KEY("halves_against", g->against), KEY("beside_finer", g->n_finer > 0),
        KEY("size_nm", f->size_nm.value), KEY("size_ci95_nm", cli_json_estimate(&f->size_nm)),
        FIELD(f, size_percent), KEY("worst", mukca_chain_joint_name(chain, f->worst)),
        FIELD(f, share),
        KEY("held_out", f->before_nm > 0 ? cli_json(FIELD(f, before_nm), FIELD(f, after_nm),
                                                    KEY("shrink_percent", shrink))
                                         : NULL),
        KEY("coefficient", sized ? cli_json(KEY("value", f->coefficient.value),
                                            KEY("unit", mukca_torque_table[g->effect].unit),
                                            KEY("ci95", cli_json_estimate(&f->coefficient)))
                                 : NULL),
        KEY("alternatives", alternatives(f, chain)),
        KEY("sentence", mukca_wording_torque(MUKCA_WORDS, g, chain)));
}

json_t *cli_motion_json(const cli_call *call)
{
    const cli_motion *w = call->work;
    const mukca_motion *m = &w->motion;
    const mukca_chain *chain = &call->session->model.chain;
    json_t *findings = json_array(), *maybe = json_array(), *joints = json_array();
    for (int i = 0; i < m->n_findings; i++)
        json_array_append_new(findings, finding(&m->finding[i], chain));
    for (int i = 0; i < m->n_maybe; i++) json_array_append_new(maybe, finding(&m->maybe[i], chain));
    for (int j = 0; j < m->n_joints; j++) {
        const mukca_motion_joint *of = &m->joint[j];
        cli_json_append(joints, KEY("joint", mukca_chain_joint_name(chain, j)),
                        FIELD(of, nominal_nm), FIELD(of, baseline_nm), FIELD(of, explained_nm),
                        FIELD(of, floor_nm), FIELD(of, range_nm), FIELD(of, moves),
                        FIELD(of, reverses));
    }
    return cli_json(KEY("verdict", mukca_motion_verdict_name[m->verdict]),
                    KEY("findings", findings), KEY("maybe", maybe), KEY("joints", joints),
                    KEY("runs", m->n_runs), KEY("reference", m->n_reference),
                    KEY("test", m->n_test), KEY("seconds", m->seconds), KEY("shift_s", m->shift_s),
                    KEY("elapsed_s", cli_elapsed(call)));
}

/* ---- table ---- */

/* A row of the table. */
typedef struct {
    const char *name, *unit;
    mukca_estimate value;
    int finding;
    double nominal, fitted; /* in the model, without the effect */
} table_parameter;

/* What the amplitude of each effect is, in the column `parameter`. */
static const char *const parameters[MUKCA_MOTION_EFFECTS] = {
    [MUKCA_MOTION_ARMATURE] = "inertia",    [MUKCA_MOTION_COULOMB] = "torque",
    [MUKCA_MOTION_VISCOUS] = "damping",     [MUKCA_MOTION_STRIBECK] = "torque",
    [MUKCA_MOTION_LOAD_FRICTION] = "share", [MUKCA_MOTION_ASYMMETRY] = "damping",
    [MUKCA_MOTION_OFFSET] = "torque",       [MUKCA_MOTION_TORQUE_GAIN] = "share",
    [MUKCA_MOTION_DELAY] = "time",          [MUKCA_MOTION_SPRING] = "stiffness",
    [MUKCA_MOTION_COGGING] = "amplitude",   [MUKCA_MOTION_THERMAL_FRICTION] = "torque"};

/* What the model has of an effect on a drive; 0: nothing. */
static double of_drive(const mukca_drives *d, int effect, int joint)
{
    return effect == MUKCA_MOTION_COULOMB    ? d->coulomb[joint]
           : effect == MUKCA_MOTION_VISCOUS  ? d->viscous[joint]
           : effect == MUKCA_MOTION_ARMATURE ? d->armature[joint]
                                             : 0;
}

static void write_parameter(cli_call *call, FILE *stream, const mukca_motion_alternative *a,
                            int joint, const table_parameter *p)
{
    fprintf(stream, "%s\t%s\t%s\t%s\t%.17g\t%.17g\t%.4f\t%d\t%.17g\t%.17g\n",
            mukca_torque_table[a->effect].name,
            mukca_chain_joint_name(&call->session->model.chain, joint), p->name, p->unit,
            p->value.value, (p->value.high - p->value.low) / (2 * MUKCA_SIGMAS_95), a->probability,
            p->finding, p->nominal, p->fitted);
}

static void write_alternative(cli_call *call, FILE *stream, const mukca_motion_alternative *a,
                              int finding)
{
    const mukca_motion *m = &((const cli_motion *)call->work)->motion;
    const mukca_torque_effect *row = &mukca_torque_table[a->effect];
    for (int j = a->all ? 0 : a->from; j <= (a->all ? m->n_joints - 1 : a->to); j++) {
        table_parameter p = {parameters[a->effect],
                             row->unit,
                             a->amplitude,
                             finding,
                             of_drive(&m->drives, a->effect, j),
                             of_drive(&m->fitted, a->effect, j)};
        if (!row->links) write_parameter(call, stream, a, j, &p);
        for (int i = 0; i < MUKCA_INERTIAL && row->links; i++) {
            const char *unit = i == 0 ? "kg" : i < 4 ? "kg*m" : "kg*m^2";
            p = (table_parameter){mukca_export_inertial[i], unit,
                                  a->inertial[i],           finding,
                                  m->inertial[j][i],        m->fitted_inertial[j][i]};
            if (p.value.high > p.value.low) write_parameter(call, stream, a, j, &p);
        }
        p = (table_parameter){"order", "1", {a->detail, a->detail, a->detail}, finding, 0, 0};
        if (row->orders) write_parameter(call, stream, a, j, &p);
    }
}

mukca_status cli_motion_table(cli_call *call, FILE *stream)
{
    const cli_motion *w = call->work;
    const mukca_chain *chain = &call->session->model.chain;
    if (!call->common->output) { /* the screen is the answer */
        call->printed = false;
        return MUKCA_OK;
    }
    fprintf(stream, "# mukca %s\n# robot: %s\n# urdf_sha256: %s\n", MUKCA_VERSION, chain->robot,
            chain->urdf_sha256);
    fputs(
        "# torque of the arm = torque of the model + effects\n"
        "# parameter of the arm = fitted + value; nominal: in the model, fitted: within the "
        "model's uncertainty\n"
        "effect\tjoint\tparameter\tunit\tvalue\tsigma\tprobability\tfinding\tnominal\tfitted\n",
        stream);
    for (int i = 0; i < w->motion.n_findings; i++) {
        const mukca_motion_finding *f = &w->motion.finding[i];
        for (int k = 0; k < f->n_alternatives; k++)
            if (f->alternative[k].effect >= 0)
                write_alternative(call, stream, &f->alternative[k], i + 1);
    }
    return MUKCA_OK;
}
