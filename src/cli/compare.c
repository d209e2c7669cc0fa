/* mukca compare: differences of two models of one arm, independent of gauge. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arm/compare.h"
#include "base/file.h"
#include "base/text.h"
#include "cli/cli.h"

typedef struct {
    mukca_corrected arm[2];
    mukca_acceptance verdict[2]; /* not `given`: no table */
    mukca_comparison comparison;
} compare_work;

static bool is_yaml(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot && (strcmp(dot, ".yaml") == 0 || strcmp(dot, ".yml") == 0);
}

/* Load a model by its kind of file: XML is a URDF, YAML a factory file; an offsets table contains
 * its chain or applies to --urdf. */
static mukca_status load(cli_call *call, int side)
{
    compare_work *w = call->work;
    cli_model *m = &call->session->model;
    mukca_corrected *arm = &w->arm[side];
    cli_arm given = call->common->arm;
    const char *path = call->arguments.items[side];
    char *text;
    MUKCA_TRY(mukca_file_read(&text, path, &call->error));
    const char **kind = text[strspn(text, " \t\r\n\xef\xbb\xbf")] == '<' ? &given.urdf
                        : is_yaml(path)                                  ? &given.kinematics
                                                                         : &given.offsets;
    *kind = path;
    free(text);
    if (given.kinematics && !given.urdf)
        return cli_fail(call, MUKCA_USAGE,
                        "%s: --urdf FILE is needed: a factory file replaces its origins",
                        mukca_file_shown(path));
    memset(m, 0, sizeof *m);
    mukca_status status = MUKCA_OK;
    if (given.offsets) status = cli_read_offsets(call, &m->offsets, &m->chain, NULL, path);
    if (!given.offsets || (status != MUKCA_OK && m->chain.n_elements == 0 && given.urdf))
        status = cli_load_model(call, m, &given);
    if (status != MUKCA_OK) return status;
    w->verdict[side] = m->offsets.acceptance;
    arm->chain = m->chain;
    mukca_geometry_set(&arm->geometry, &arm->chain, m->offsets.theta);
    arm->n_effects = m->offsets.n_effects;
    memcpy(arm->effects, m->offsets.effects, sizeof arm->effects);
    return MUKCA_OK;
}

/* The arms must have equal numbers of joints, which are paired in order. */
static mukca_status check_pairs(cli_call *call)
{
    const compare_work *w = call->work;
    const mukca_chain *a = &w->arm[0].chain, *b = &w->arm[1].chain;
    const char *const *path = call->arguments.items;
    if (a->n_joints != b->n_joints)
        return cli_fail(call, MUKCA_INPUT,
                        "%.60s has %d joints from '%s' to '%s', %.60s has %d from '%s' to '%s'; "
                        "choose with --base and --tip",
                        mukca_file_shown(path[0]), a->n_joints, a->base, a->tip,
                        mukca_file_shown(path[1]), b->n_joints, b->base, b->tip);
    for (int j = 0; j < a->n_joints; j++) {
        const mukca_element *x = &a->element[a->joint_element[j]],
                            *y = &b->element[b->joint_element[j]];
        if (mukca_joint_turns(x->type) != mukca_joint_turns(y->type))
            return cli_fail(call, MUKCA_INPUT,
                            "joint '%s' of %.60s turns or slides, joint '%s' of %.60s does not; "
                            "they are not models of one arm",
                            x->name, mukca_file_shown(path[0]), y->name, mukca_file_shown(path[1]));
        if (strcmp(x->name, y->name) != 0) {
            cli_note(call, "joints are paired in order: '%s' with '%s', ...", x->name, y->name);
            break;
        }
    }
    return MUKCA_OK;
}

static void print_number(cli_call *call, double value)
{
    if (isfinite(value)) /* avoids -0.0000 */
        cli_answer(call, " %12.4f", fabs(value) < 5e-8 ? 0 : 1e3 * value);
    else
        cli_answer(call, " %12s", "-");
}

static mukca_status print(cli_call *call)
{
    static const char *const row[2] = {"as they are", "base and tool aligned"};
    const compare_work *w = call->work;
    const mukca_comparison *c = &w->comparison;
    for (int side = 0; side < 2; side++) {
        const char key[2] = {side ? 'B' : 'A'};
        char text[MUKCA_ACCEPTANCE_SENTENCE] = "";
        if (w->verdict[side].given)
            mukca_acceptance_put_brief(&(mukca_text)MUKCA_TEXT(text), &w->verdict[side]);
        cli_say(call, key, "%s: %s, %d joints%s%s", call->arguments.items[side],
                w->arm[side].chain.robot, w->arm[side].chain.n_joints, *text ? "; " : "", text);
    }
    cli_answer(call, "Tip, %d postures             mean     95 %%      max\n", MUKCA_COMPARED);
    for (int aligned = 0; aligned < 2; aligned++) {
        const mukca_compared_error *p = &c->position[aligned], *r = &c->rotation[aligned];
        cli_answer(call, "  %-21s %8.3f %8.3f %8.3f mm\n", row[aligned], 1e3 * p->mean,
                   1e3 * p->p95, 1e3 * p->max);
        cli_answer(call, "  %-21s %8.3f %8.3f %8.3f mrad\n", "", 1e3 * r->mean, 1e3 * r->p95,
                   1e3 * r->max);
    }
    cli_answer(call,
               "Axes of B against A, each seen from the axis before it\n"
               "  %-20s %12s %12s %12s %12s\n",
               "joint", "angle, mrad", "distance, mm", "zero, mrad", "shift, mm");
    for (int j = 0; j < w->arm[0].chain.n_joints; j++) {
        const mukca_axis_difference *d = &c->axis[j];
        cli_answer(call, "  %-20s", mukca_chain_joint_name(&w->arm[0].chain, j));
        print_number(call, d->angle);
        print_number(call, d->distance);
        print_number(call, d->zero);
        print_number(call, d->slide);
        cli_answer(call, "\n");
    }
    return MUKCA_OK;
}

static json_t *error_json(const mukca_compared_error *e, bool angle)
{
    return cli_json(KEY(angle ? "mean_rad" : "mean_m", e->mean),
                    KEY(angle ? "p95_rad" : "p95_m", e->p95),
                    KEY(angle ? "max_rad" : "max_m", e->max));
}

static json_t *errors_json(const mukca_compared_error e[2], bool angle)
{
    return cli_json(KEY("as_they_are", error_json(&e[0], angle)),
                    KEY("aligned", error_json(&e[1], angle)));
}

static json_t *as_json(const cli_call *call)
{
    const compare_work *w = call->work;
    const mukca_comparison *c = &w->comparison;
    json_t *axes = json_array(), *models = json_array();
    for (int side = 0; side < 2; side++)
        cli_json_append(
            models, KEY("file", call->arguments.items[side]),
            KEY("robot", w->arm[side].chain.robot),
            KEY("acceptance",
                w->verdict[side].given ? cli_json_acceptance(&w->verdict[side]) : NULL));
    for (int j = 0; j < w->arm[0].chain.n_joints; j++)
        cli_json_append(axes, KEY("angle_rad", c->axis[j].angle),
                        KEY("distance_m", c->axis[j].distance), KEY("zero_rad", c->axis[j].zero),
                        KEY("shift_m", c->axis[j].slide),
                        KEY("joint", mukca_chain_joint_name(&w->arm[0].chain, j)));
    return cli_json(KEY("models", models), KEY("postures", (int)MUKCA_COMPARED), KEY("axes", axes),
                    KEY("position", errors_json(c->position, false)),
                    KEY("rotation", errors_json(c->rotation, true)),
                    KEY("base", cli_json_frame(&c->base)), KEY("tool", cli_json_frame(&c->tool)),
                    KEY("elapsed_s", cli_elapsed(call)));
}

static mukca_status check(cli_call *call)
{
    if (!call->common->arm.kinematics) return MUKCA_OK;
    return cli_fail(call, MUKCA_USAGE, "--kinematics: give the file as A or as B");
}

static mukca_status run(cli_call *call)
{
    compare_work *w = call->work;
    MUKCA_TRY(load(call, 0));
    MUKCA_TRY(load(call, 1));
    MUKCA_TRY(check_pairs(call));
    mukca_compare(&w->comparison, &w->arm[0], &w->arm[1]);
    return MUKCA_OK;
}

const cli_command cli_command_compare = {
    .name = "compare",
    .group = CLI_UNDERSTAND,
    .summary = "differences between two models of one arm: axes and tip",
    .synopsis = "A B",
    .description =
        "A and B are URDFs, factory files (YAML, with --urdf) or offsets tables: nominal and "
        "calibrated, or this year's table and last year's. The position of the base frame, the "
        "tool and the links' frames is a convention (gauge) and is not compared.\n\n"
        "Tip: distance of the two tips in postures drawn within the joint limits of A, for the "
        "models as given, and with the base and the tool of B aligned to A (least squares).\n\n"
        "Axes: for each joint the angle between its two axes and their distance, relative to the "
        "preceding axis; the difference of the joint's zero and the shift along the axis to the "
        "next one. A dash marks gauge, and what is undetermined because axes are parallel.\n\n"
        "A table without the arm's chain in its comments (made by hand) belongs to --urdf.",
    .example = "  mukca compare data/demo/arm.urdf build/demo/offsets.tsv",
    .with = CLI_WITH_MODEL | CLI_WITH_JSON,
    .options_size = sizeof(cli_common),
    .any_table = true,
    .check = check,
    .run = run,
    .json = as_json,
    .print = print,
    .work_size = sizeof(compare_work),
};
