/* The report's sentences and tables, from the calibration's and the diagnosis' JSON. */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "mukca/effect.h"
#include "report/parts.h"

static const double mm = 1e3;

double report_real(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

const char *report_text(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

/* The catalogue's name with spaces, "joint compliance". */
static void say_effect(char *text, size_t size, const char *name)
{
    snprintf(text, size, "%s", name);
    for (char *c = text; *c; c++)
        if (*c == '_') *c = ' ';
}

void report_name_cause(char *text, size_t size, const json_t *cause)
{
    const char *joint = report_text(cause, "joint"), *place = report_text(cause, "placement"),
               *socket = report_text(cause, "socket");
    const double order = report_real(cause, "order");
    char effect[64], often[48] = "";
    say_effect(effect, sizeof effect, report_text(cause, "effect"));
    if (order > 0) snprintf(often, sizeof often, " %g per turn", order);
    snprintf(text, size, "%s%s%s%s%s%s%s%s", effect, often, *joint ? " of " : "", joint,
             *place ? " in " : "", place, *socket ? " socket " : "", socket);
}

/* A cell: value times `factor`, with so many decimals, or -decimals significant digits; a dash
 * where the value is not known. */
static void cell(FILE *out, double value, double factor, int decimals)
{
    fputs("<td class=\"n\">", out);
    value *= factor;
    if (decimals >= 0 && fabs(value) < 0.5 * pow(10, -decimals)) value = 0; /* no "-0.00" */
    if (!isfinite(value))
        fputs("&ndash;", out);
    else if (decimals < 0)
        fprintf(out, "%.*g", -decimals, value);
    else
        fprintf(out, "%.*f", decimals, value);
    fputs("</td>", out);
}

static void text_cell(FILE *out, const char *text)
{
    fputs("<td>", out);
    mukca_html_escape(out, text);
    fputs("</td>", out);
}

/* The head of a table that scrolls by itself on narrow screens; columns parted by '|', those that
 * begin with '#' hold numbers. */
static void begin_table(FILE *out, const char *caption, const char *columns)
{
    fputs("<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"", out);
    mukca_html_escape(out, caption);
    fputs("\">\n<table>\n<caption>", out);
    mukca_html_escape(out, caption);
    fputs("</caption>\n<thead><tr>", out);
    while (*columns) {
        const size_t n = strcspn(columns, "|");
        const bool number = *columns == '#';
        fprintf(out, "<th scope=\"col\"%s>", number ? " class=\"n\"" : "");
        for (size_t c = number; c < n; c++) mukca_html_escape(out, (char[]){columns[c], '\0'});
        fputs("</th>", out);
        columns += n + (columns[n] == '|');
    }
    fputs("</tr></thead>\n<tbody>\n", out);
}

static void end_table(FILE *out)
{
    fputs("</tbody>\n</table>\n</div>\n", out);
}

/* ---- the verdict ---- */

/* Mean over the placements of the held-out ones, else of the training ones. */
static double mean_error(const json_t *calibration, const char *key, bool *held_out)
{
    const json_t *list = json_object_get(calibration, "test"), *p;
    double sum = 0;
    size_t i;
    *held_out = json_array_size(list) > 0;
    if (!*held_out) list = json_object_get(calibration, "train");
    json_array_foreach(list, i, p) sum += report_real(p, key);
    return json_array_size(list) ? sum / (double)json_array_size(list) : (double)NAN;
}

static void tile(FILE *out, const char *label, double value, double factor, const char *unit)
{
    if (!isfinite(value)) return;
    fputs("<div><dt>", out);
    mukca_html_escape(out, label);
    fprintf(out, "</dt><dd>%.3g <small>%s</small></dd></div>\n", value * factor, unit);
}

static void say_verdict(FILE *out, const json_t *diagnosis)
{
    static const struct {
        const char *verdict, *sentence;
    } sentences[] = {
        {"none", "What remains after calibration is noise: no effect can be told from it."},
        {"named", "The gap that remains after calibration has a name: "},
        {"tied",
         "The gap that remains after calibration has names that these data cannot all tell "
         "from others: "},
        {"unknown", "A gap remains that no effect of the catalogue explains."},
        {"untestable", "These data are too few to test causes of what remains."},
    };
    const char *verdict = report_text(diagnosis, "verdict");
    const json_t *causes = json_object_get(diagnosis, "causes"), *cause, *tie;
    size_t i, k;
    fprintf(out, "<p class=\"verdict %s\">", verdict);
    for (i = 0; i < sizeof sentences / sizeof *sentences; i++)
        if (strcmp(verdict, sentences[i].verdict) == 0) fputs(sentences[i].sentence, out);
    if (strcmp(verdict, "named") == 0 || strcmp(verdict, "tied") == 0) {
        json_array_foreach(causes, i, cause)
        {
            char name[160];
            report_name_cause(name, sizeof name, cause);
            fputs(i ? "; <strong>" : "<strong>", out);
            mukca_html_escape(out, name);
            fputs("</strong>", out);
            json_array_foreach(json_object_get(cause, "ties"), k, tie)
            {
                report_name_cause(name, sizeof name, tie);
                fputs(" or ", out);
                mukca_html_escape(out, name);
            }
            if (json_is_true(json_object_get(cause, "or_unknown")))
                fputs(" or something unknown", out);
        }
        fputs(".", out);
    }
    if (json_is_true(json_object_get(diagnosis, "unexplained")))
        fputs(" Some structure remains unexplained.", out);
    fputs("</p>\n", out);
}

void report_put_verdict(FILE *out, const mukca_report *r)
{
    const json_t *gap = json_object_get(r->diagnosis, "gap");
    bool held_out;
    char of[24];
    const double nominal = mean_error(r->calibration, "mae_nominal_m", &held_out);
    const double calibrated = mean_error(r->calibration, "mae_m", &held_out);
    if (!json_is_true(json_object_get(r->calibration, "converged")))
        fputs(
            "<p class=\"verdict unknown\">The calibration did <strong>not converge</strong>: do "
            "not "
            "use its numbers.</p>\n",
            out);
    if (r->diagnosis) say_verdict(out, r->diagnosis);
    fputs("<dl class=\"tiles\">\n", out);
    tile(out, held_out ? "nominal, test data" : "nominal, training data", nominal, mm, "mm");
    tile(out, held_out ? "calibrated, test data" : "calibrated, training data", calibrated, mm,
         "mm");
    tile(out, "cross-validated, geometry", report_real(gap, "geometry_m"), mm, "mm");
    tile(out, "cross-validated, with the causes", report_real(gap, "explained_m"), mm, "mm");
    tile(out, "noise floor", report_real(gap, "noise_floor_m"), mm, "mm");
    tile(out, "rows", r->data->n_rows, 1, "");
    tile(out, "placements", r->data->n_placements, 1, "");
    snprintf(of, sizeof of, "of %zu",
             json_array_size(json_object_get(r->calibration, "parameters")));
    tile(out, "parameter directions seen", report_real(r->calibration, "rank"), 1, of);
    fputs("</dl>\n", out);
}

/* ---- causes ---- */

void report_put_causes(FILE *out, const mukca_report *r)
{
    const json_t *causes = json_object_get(r->diagnosis, "causes"), *cause, *tie;
    size_t i, k;
    if (json_array_size(causes) == 0) return;
    begin_table(
        out, "Causes, in the order of what each explains",
        "cause|#size|#95 % interval|unit|#probability|#held-out error shrinks by, %|what it is");
    json_array_foreach(causes, i, cause)
    {
        const json_t *ci = json_object_get(cause, "ci95"),
                     *held = json_object_get(cause, "held_out");
        const char *name = report_text(cause, "effect"), *unit = report_text(cause, "unit");
        const int kind = mukca_effect_find(name);
        double factor = 1;
        char label[160];
        if (kind >= 0 && strcmp(unit, mukca_effect_table[kind].unit) == 0) {
            factor = mukca_effect_table[kind].display_factor;
            unit = mukca_effect_table[kind].display_unit;
        }
        report_name_cause(label, sizeof label, cause);
        fputs("<tr>", out);
        text_cell(out, label);
        cell(out, report_real(cause, "amplitude"), factor, -3);
        fputs("<td class=\"n\">", out);
        if (json_array_size(ci) == 2)
            fprintf(out, "%.3g &hellip; %.3g", json_number_value(json_array_get(ci, 0)) * factor,
                    json_number_value(json_array_get(ci, 1)) * factor);
        fputs("</td>", out);
        text_cell(out, unit);
        if (report_real(cause, "probability") > 0.999)
            fputs("<td class=\"n\">&gt; 0.999</td>", out);
        else
            cell(out, report_real(cause, "probability"), 1, 3);
        cell(out, report_real(held, "shrink_percent"), 1, 0);
        text_cell(out, kind >= 0 ? mukca_effect_table[kind].sentence : "");
        fputs("</tr>\n", out);
    }
    end_table(out);
    bool any = false;
    json_array_foreach(causes, i, cause)
    {
        json_array_foreach(json_object_get(cause, "ties"), k, tie)
        {
            char left[160], right[160];
            if (!any)
                begin_table(out, "Ties: causes that these data tell apart badly",
                            "cause|#log Bayes factor|or|#log Bayes factor|#correlation");
            any = true;
            report_name_cause(left, sizeof left, cause);
            report_name_cause(right, sizeof right, tie);
            fputs("<tr>", out);
            text_cell(out, left);
            cell(out, report_real(cause, "log_bayes_factor"), 1, 1);
            text_cell(out, right);
            cell(out, report_real(tie, "log_bayes_factor"), 1, 1);
            cell(out, report_real(tie, "correlation"), 1, 2);
            fputs("</tr>\n", out);
        }
    }
    if (any) end_table(out);
}

void report_put_untestable(FILE *out, const mukca_report *r)
{
    const json_t *tested = json_object_get(r->diagnosis, "tested"), *t;
    bool any = false;
    size_t i;
    json_array_foreach(tested, i, t)
    {
        if (!json_is_false(json_object_get(t, "testable"))) continue;
        if (!any) begin_table(out, "What these data cannot show", "effect|why");
        any = true;
        char name[160];
        report_name_cause(name, sizeof name, t);
        fputs("<tr>", out);
        text_cell(out, name);
        text_cell(out, report_text(t, "why"));
        fputs("</tr>\n", out);
    }
    if (any) end_table(out);
}

/* ---- placements, faults, offsets, poses ---- */

void report_put_placements(FILE *out, const mukca_report *r)
{
    static const char *const lists[2] = {"train", "test"};
    const json_t *p;
    size_t i;
    begin_table(out, "Errors by placement, mm",
                "placement|used for|#rows|#error nominal|#error calibrated|#rms nominal|#rms "
                "calibrated|#distance error nominal|#distance error calibrated");
    for (int k = 0; k < 2; k++) {
        json_array_foreach(json_object_get(r->calibration, lists[k]), i, p)
        {
            fputs("<tr>", out);
            text_cell(out, report_text(p, "placement"));
            text_cell(out, k ? "test" : "training");
            cell(out, report_real(p, "rows"), 1, 0);
            cell(out, report_real(p, "mae_nominal_m"), mm, 3);
            cell(out, report_real(p, "mae_m"), mm, 3);
            cell(out, report_real(p, "std_nominal_m"), mm, 3);
            cell(out, report_real(p, "std_m"), mm, 3);
            cell(out, report_real(p, "distance_error_nominal_m"), mm, 3);
            cell(out, report_real(p, "distance_error_m"), mm, 3);
            fputs("</tr>\n", out);
        }
    }
    end_table(out);
}

void report_put_faults(FILE *out, const mukca_report *r)
{
    const json_t *faults = json_object_get(r->diagnosis, "data_faults"), *fault;
    size_t i;
    if (!r->diagnosis) return;
    if (json_array_size(faults) == 0) {
        fputs("<p>No fault of recording was found.</p>\n", out);
        return;
    }
    begin_table(out, "Faults of recording", "fault|placement|socket|#row of the file|#size, mm");
    json_array_foreach(faults, i, fault)
    {
        char kind[64];
        say_effect(kind, sizeof kind, report_text(fault, "kind"));
        fputs("<tr>", out);
        text_cell(out, kind);
        text_cell(out, report_text(fault, "placement"));
        text_cell(out, report_text(fault, "socket"));
        cell(out, report_real(fault, "row"), 1, 0);
        cell(out, report_real(fault, "size_m"), mm, 2);
        fputs("</tr>\n", out);
    }
    end_table(out);
}

void report_put_offsets(FILE *out, const mukca_report *r)
{
    const json_t *p;
    size_t i;
    begin_table(out,
                "Offsets: calibrated = nominal + offset, in the URDF's origins; no sigma: the rows "
                "alone do not tell it",
                "joint|parameter|unit|#nominal|#calibrated|#offset|#sigma|identifiable");
    json_array_foreach(json_object_get(r->calibration, "parameters"), i, p)
    {
        const json_t *known = json_object_get(p, "identifiable");
        fputs("<tr>", out);
        text_cell(out, report_text(p, "joint"));
        text_cell(out, report_text(p, "parameter"));
        text_cell(out, report_text(p, "unit"));
        cell(out, report_real(p, "nominal"), 1, 6);
        cell(out, report_real(p, "calibrated"), 1, 6);
        cell(out, report_real(p, "offset"), 1, 6);
        cell(out, report_real(p, "sigma"), 1, 6);
        text_cell(out, json_is_true(known) ? "yes" : "no");
        fputs("</tr>\n", out);
    }
    end_table(out);
}

void report_put_next_poses(FILE *out, const mukca_report *r)
{
    const json_t *poses = json_object_get(r->diagnosis, "next_poses"), *pose, *cause;
    size_t i, k;
    char columns[MUKCA_MAX_JOINTS * (MUKCA_NAME_SIZE + 2) + 64] = "placement|socket";
    if (json_array_size(poses) == 0) return;
    fputs("<p>These poses would tell apart ", out);
    json_array_foreach(json_object_get(json_array_get(poses, 0), "tells_apart"), k, cause)
    {
        char name[160];
        report_name_cause(name, sizeof name, cause);
        fputs(k ? " and " : "", out);
        mukca_html_escape(out, name);
    }
    fputs(".</p>\n", out);
    for (int j = 0; j < r->chain->n_joints; j++) {
        strcat(columns, "|#");
        strcat(columns, r->chain->element[r->chain->joint_element[j]].name);
    }
    begin_table(out, "Next poses, rad", columns);
    json_array_foreach(poses, i, pose)
    {
        const json_t *q = json_object_get(pose, "q");
        fputs("<tr>", out);
        text_cell(out, report_text(pose, "placement"));
        text_cell(out, report_text(pose, "socket"));
        for (int j = 0; j < r->chain->n_joints; j++)
            cell(out, json_number_value(json_array_get(q, (size_t)j)), 1, 3);
        fputs("</tr>\n", out);
    }
    end_table(out);
}

/* ---- provenance ---- */

void report_put_provenance(FILE *out, const mukca_report *r)
{
    const json_t *solver = json_object_get(r->calibration, "solver");
    fputs("<p>Made by <code>", out);
    mukca_html_escape(out, r->command);
    fprintf(out, "</code> at %s.", r->when);
    if (solver)
        fprintf(out, " Solver %s with gradient %s: %.0f evaluations, %.0f iterations.",
                report_text(solver, "name"), report_text(solver, "gradient"),
                report_real(solver, "evaluations"), report_real(solver, "iterations"));
    fputs("</p>\n", out);
    begin_table(out, "Files read", "file|SHA-256");
    for (int i = 0; i < r->n_files; i++) {
        fputs("<tr>", out);
        text_cell(out, r->files[i].path);
        fprintf(out, "<td><code>%s</code></td></tr>\n", r->files[i].sha256);
    }
    end_table(out);
}
