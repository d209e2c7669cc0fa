/* Scores of a model on data, nominal and calibrated. */
#include "cli/scores.h"
#include "base/file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "fit/mismatch.h"

/* Copy the parameters of the URDF to those of a chain that may have additional elements (frames of
 * pose logs). */
static void take_urdf_theta(double *theta, const mukca_chain *chain, const mukca_chain *urdf)
{
    for (int k = 0; k < chain->n_elements; k++) {
        const int from = mukca_chain_find_element(urdf, chain->element[k].name);
        if (from < 0) continue;
        memcpy(theta + MUKCA_PARAMETERS * k, urdf->element[from].xyz, 3 * sizeof *theta);
        memcpy(theta + MUKCA_PARAMETERS * k + 3, urdf->element[from].rpy, 3 * sizeof *theta);
    }
}

/* False: out of memory. */
static bool score(cli_scored *set, mukca_pool *pool, const mukca_model models[CLI_MODELS],
                  bool factory)
{
    for (int m = 0; m < CLI_FACTORY + factory && set->n >= 0; m++) {
        set->score[m] = MUKCA_TAKE(pool, mukca_score, mukca_evaluate_room(set->data));
        set->n = set->score[m] ? mukca_evaluate(set->score[m], &set->mean[m], &models[m], set->data)
                               : -1;
    }
    return set->n >= 0;
}

mukca_status cli_scores_make(cli_call *call, cli_scores *scores, const mukca_chain *chain,
                             const mukca_offsets *offsets, const char *name)
{
    cli_session *s = call->session;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    double urdf[MUKCA_MAX_THETA];
    scores->set[0] = (cli_scored){.name = name, .data = &s->data};
    scores->set[1] = (cli_scored){.name = "test", .data = &s->test};
    scores->has_factory = call->common->arm.kinematics != NULL;
    mukca_chain_theta(urdf, chain);
    if (scores->nominal_theta)
        memcpy(urdf, scores->nominal_theta,
               MUKCA_PARAMETERS * (size_t)chain->n_elements * sizeof *urdf);
    if (scores->has_factory) take_urdf_theta(urdf, chain, &s->model.urdf);
    for (cli_scored *set = scores->set; set < scores->set + 2 && set->data->n_rows > 0; set++) {
        const mukca_dataset *d = set->data;
        const bool by_log = scores->by_log && (d->n_files > 1 || d->n_targets > 1);
        mukca_offsets_place_effects(effects, offsets, d);
        const mukca_model models[CLI_MODELS] = {
            [CLI_NOMINAL] = {.chain = chain, .theta = urdf, .by_log = by_log},
            [CLI_FACTORY] = {.chain = chain, .theta = scores->nominal_theta, .by_log = by_log},
            [CLI_CALIBRATED] = {.chain = chain,
                                .theta = offsets->theta,
                                .effects = effects,
                                .n_effects = offsets->n_effects,
                                .by_log = by_log}};
        if (!score(set, &call->pool, models, scores->has_factory))
            return cli_fail(call, MUKCA_MEMORY, "out of memory for %d rows", d->n_rows);
    }
    return MUKCA_OK;
}

/* Write a tab and the number, empty if not finite. */
static void write_number(FILE *stream, double value)
{
    fputc('\t', stream);
    if (isfinite(value)) fprintf(stream, "%.17g", value);
}

enum { NAME = 192 };

/* "panda/front"; "poses" for all pose logs, "log.csv" or "log.csv:target" for one. */
static const char *find_name(char name[NAME], const mukca_score *score, const mukca_dataset *data)
{
    if (score->placement >= 0) return data->placements[score->placement].name;
    if (score->file < 0) return "poses";
    snprintf(name, NAME, "%.100s%s%s", mukca_file_name(data->files[score->file]),
             score->target < 0 ? "" : ":", score->target < 0 ? "" : data->targets[score->target]);
    mukca_utf8_mend(name);
    return name;
}

/* The figures of a score, by column and JSON key. */
static const struct {
    const char *key[CLI_MODELS];
    size_t offset;
} figures[] = {{{"mae_nominal_m", "mae_m", "mae_factory_m"}, offsetof(mukca_score, mae)},
               {{"std_nominal_m", "std_m", "std_factory_m"}, offsetof(mukca_score, std)},
               {{"distance_error_nominal_m", "distance_error_m", "distance_error_factory_m"},
                offsetof(mukca_score, distance_error)},
               {{"rotation_error_nominal_rad", "rotation_error_rad", "rotation_error_factory_rad"},
                offsetof(mukca_score, rotation_error)}};
enum { FIGURES = sizeof figures / sizeof *figures, ROTATION = FIGURES - 1 };

static double figure(const mukca_score *score, int k)
{
    return *(const double *)(const void *)((const char *)score + figures[k].offset);
}

void cli_scores_write(FILE *stream, const cli_scores *scores)
{
    fputs("set\tplacement\trows", stream);
    for (int k = 0; k < FIGURES; k++)
        fprintf(stream, "\t%s\t%s", figures[k].key[CLI_NOMINAL], figures[k].key[CLI_CALIBRATED]);
    for (int k = 0; k < FIGURES && scores->has_factory; k++)
        fprintf(stream, "\t%s", figures[k].key[CLI_FACTORY]);
    fputc('\n', stream);
    for (const cli_scored *set = scores->set; set < scores->set + 2; set++)
        for (int i = 0; i < set->n; i++) {
            char name[NAME];
            const mukca_score *after = &set->score[CLI_CALIBRATED][i];
            fprintf(stream, "%s\t%s\t%d", set->name, find_name(name, after, set->data),
                    after->rows);
            for (int k = 0; k < FIGURES; k++) {
                write_number(stream, figure(&set->score[CLI_NOMINAL][i], k));
                write_number(stream, figure(after, k));
            }
            for (int k = 0; k < FIGURES && scores->has_factory; k++)
                write_number(stream, figure(&set->score[CLI_FACTORY][i], k));
            fputc('\n', stream);
        }
}

json_t *cli_scores_json(const cli_scored *set, bool factory)
{
    json_t *array = json_array();
    for (int i = 0; i < set->n; i++) {
        char name[NAME];
        const mukca_score *after = &set->score[CLI_CALIBRATED][i];
        json_t *object =
            cli_json(KEY("placement", find_name(name, after, set->data)), FIELD(after, rows));
        for (int k = 0; k < FIGURES; k++)
            for (int m = 0; m < CLI_FACTORY + factory; m++)
                if (k != ROTATION || isfinite(figure(after, k)))
                    json_object_set_new(object, figures[k].key[m],
                                        cli_json_real(figure(&set->score[m][i], k)));
        json_array_append_new(array, object);
    }
    return array;
}

/* A figure of the models in mm or mrad, of a placement (-1: mean over all). */
static void print_figures(cli_call *call, const char *name, int k, const cli_scores *s,
                          const cli_scored *set, int row)
{
    double value[CLI_MODELS] = {0};
    for (int m = 0; m < CLI_FACTORY + s->has_factory; m++)
        value[m] = figure(row < 0 ? &set->mean[m] : &set->score[m][row], k);
    cli_answer(call, "  %-24s %12.3f", name, 1e3 * value[CLI_NOMINAL]);
    if (s->has_factory) cli_answer(call, " %12.3f", 1e3 * value[CLI_FACTORY]);
    if (s->calibrated) cli_answer(call, " %12.3f", 1e3 * value[CLI_CALIBRATED]);
    if (s->calibrated && value[CLI_NOMINAL] > 0)
        cli_answer(call, " %+11.2f %%", 100 * (value[CLI_CALIBRATED] / value[CLI_NOMINAL] - 1));
    cli_answer(call, "\n");
}

static void print_set(cli_call *call, const cli_scores *s, const cli_scored *set, bool rows)
{
    const bool sockets = isfinite(set->mean[CLI_NOMINAL].distance_error);
    const char *const kinds[FIGURES] = {sockets ? "consistency mm" : "position mm", NULL,
                                        "distortion mm", "rotation mrad"};
    char text[NAME + 40], name[NAME];
    for (int k = 0; k < FIGURES && set->n > 0; k++) {
        if (!kinds[k] || !isfinite(figure(&set->mean[CLI_NOMINAL], k))) continue;
        snprintf(text, sizeof text, "%s, %s", kinds[k], set->name);
        print_figures(call, text, k, s, set, -1);
    }
    for (int i = 0; i < set->n && set->n > 1 && rows; i++) {
        snprintf(text, sizeof text, "  %.24s",
                 find_name(name, &set->score[CLI_CALIBRATED][i], set->data));
        print_figures(call, text, 0, s, set, i);
    }
}

void cli_scores_print(cli_call *call, const cli_scores *s, bool rows)
{
    cli_answer(call, "  %-24s %12s%s%s\n", "Error", "nominal",
               s->has_factory ? "      factory" : "", s->calibrated ? "   calibrated" : "");
    print_set(call, s, &s->set[0], rows);
    print_set(call, s, &s->set[1], rows);
}

/* A list of changes: "with A, and B". */
typedef struct {
    mukca_text text;
    int n;
} changes;

#define put_change(list, ...)                                         \
    (mukca_text_put(&(list)->text, (list)->n++ ? ", and " : "with "), \
     mukca_text_put(&(list)->text, __VA_ARGS__))

static void put_base(changes *list, const mukca_mixup *m, const mukca_chain *chain)
{
    double w[3];
    mukca_rotation_log(w, m->base_frame.R);
    const double turn = mukca_norm3(w);
    for (int c = 0; c < 3; c++) w[c] = nearbyint(100 * w[c] / turn) / 100 + 0.0; /* no -0 */
    put_change(list,
               "the base turned by %.4g degrees about (%g %g %g) and moved by %.4g mm in the frame "
               "of the poses",
               turn * 180 / M_PI, w[0], w[1], w[2], 1e3 * mukca_norm3(m->base_frame.p));
    if (m->equivalent_shift != 0)
        mukca_text_put(&list->text, " (or %+.4g degrees added to %s)",
                       m->equivalent_shift * 180 / M_PI, mukca_chain_joint_name(chain, 0));
}

static void put_mixup(changes *list, const mukca_mixup *m, const mukca_chain *chain)
{
    const int n = chain->n_joints;
    const char *name[MUKCA_MAX_JOINTS];
    for (int j = 0; j < n; j++) name[j] = mukca_chain_joint_name(chain, j);
    for (int j = 0, k = 0; j < n; j++)
        if (m->reversed >> j & 1 && k++)
            mukca_text_put(&list->text, ", %s", name[j]);
        else if (m->reversed >> j & 1)
            put_change(list, "the opposite sign of %s", name[j]);
    for (int j = 0; j < n; j++) {
        const int from = m->from[j], other = abs(m->coupled[j]) - 1;
        if (m->from[from] != j)
            put_change(list, "the column of %s read as %s", name[from], name[j]);
        else if (from > j)
            put_change(list, "the columns of %s and %s exchanged", name[j], name[from]);
        if (m->shift[j] != 0)
            put_change(list, "%+.4g degrees added to %s", m->shift[j] * 180 / M_PI, name[j]);
        if (other >= 0)
            put_change(list, "%s %s %s (as where the controller counts %s from the horizontal)",
                       name[other], m->coupled[j] > 0 ? "added to" : "subtracted from", name[j],
                       name[j]);
    }
    if (m->base) put_base(list, m, chain);
}

void cli_print_mismatch(cli_call *call, const mukca_dataset *data, bool free_base, bool free_tool)
{
    const mukca_chain *chain = &call->session->model.chain;
    mukca_mismatch m;
    mukca_error error; /* only a hint: omitted if out of memory */
    char text[600] = "";
    if (mukca_mismatch_find(&m, chain, data, free_base, free_tool, &error) != MUKCA_OK || !m.found)
        return;
    put_mixup(&(changes){.text = MUKCA_TEXT(text)}, &m.mixup, chain);
    cli_say(call, NULL,
            "The data would agree with the nominal model to %.3f mm instead of %.3f mm %s: check "
            "%s%s and the URDF.",
            1e3 * m.mixup.error_m, 1e3 * m.before_m, text,
            m.mixup.base ? "--base (base and base_link may differ; --free-base fits it)"
                         : "these columns",
            m.mixup.reversed && data->n_sockets == 0
                ? ", the order of x, y and z (an exchange mirrors the arm)"
                : "");
}
