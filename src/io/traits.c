/* Traits of an arm model as a table: provenance in `#` lines, one row per coefficient or order. */
#include "io/summary.h"

#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "io/table.h"
#include "mukca/version.h"

/* Columns of the table, in order: those of the effect, then numbers at an offset in mukca_trait
 * (ARMS: a count).  Rows of orders leave cells without value empty. */
enum { EFFECT, JOINT, TERM, UNIT, MEAN, SPREAD, ARMS, EVIDENCE, PROBABILITY, ERROR, COLUMNS = 13 };
static const struct {
    const char *name;
    size_t offset;
} columns[COLUMNS] = {
    {"effect", 0},
    {"joint", 0},
    {"term", 0},
    {"unit", 0},
    {"mean", offsetof(mukca_trait, mean)},
    {"spread", offsetof(mukca_trait, spread)},
    {"arms", 0},
    {"log_bayes_factor", offsetof(mukca_trait, log_bayes_factor)},
    {"probability", offsetof(mukca_trait, probability)},
    {"error", offsetof(mukca_trait, error)},
    {"value", offsetof(mukca_trait, value)},
    {"low", offsetof(mukca_trait, low)},
    {"high", offsetof(mukca_trait, high)},
};

void mukca_traits_write(FILE *stream, const mukca_traits *t)
{
    const mukca_fleet_model *m = &t->model;
    fputs("# mukca " MUKCA_VERSION " traits table\n", stream);
    fprintf(stream, "# robot: %s\n# base: %s\n# tip: %s\n# joints:", m->robot, m->base, m->tip);
    for (int j = 0; j < m->n_joints; j++) fprintf(stream, "%s%s", j ? ", " : " ", m->joint[j]);
    fprintf(stream, "\n# geometry: %016" PRIx64 "\n# masses: %016" PRIx64 "\n", m->geometry,
            m->masses);
    fprintf(stream, "# arms: %d\n# sessions: %d\n# samples: %d\n", t->n_arms, t->n_sessions,
            t->n_samples);
    fputs(
        "# mean, error: of the fleet, with its standard error; spread: standard deviation between "
        "arms: the prior of one more arm\n# probability: that the arms share it; value, low, high: "
        "its mean if so, with its 95 % interval, coefficients that are not shared being 0\n",
        stream);
    for (int c = 0; c < COLUMNS; c++) fprintf(stream, "%s%s", c ? "\t" : "", columns[c].name);
    for (int i = 0; i < t->n; i++) {
        const mukca_trait *r = &t->list[i];
        char term[MUKCA_EFFECT_TEXT];
        mukca_effect_variant_text(term, &r->effect);
        const bool order = mukca_effect_has((int)r->effect.kind, MUKCA_TRAIT_ORDERS);
        fprintf(stream, "\n%s\t%s\t%s%s\t%s", mukca_effect_table[r->effect.kind]->name,
                r->effect.joint < 0 ? "" : m->joint[r->effect.joint], order ? "order=" : "", term,
                mukca_effect_table[r->effect.kind]->unit);
        for (int c = MEAN; c < COLUMNS; c++) {
            double value = r->arms;
            if (c != ARMS) memcpy(&value, (const char *)r + columns[c].offset, sizeof value);
            fprintf(stream, isfinite(value) ? "\t%.9g" : "\t", value);
        }
    }
    fputc('\n', stream);
}

/* The text behind a `# key: ` before the header; NULL: none. */
static const char *head(const mukca_table *table, const char *key)
{
    const size_t length = strlen(key);
    for (const char *line = table->comments; *line;
         line += strcspn(line, "\n"), line += *line != 0) {
        const char *at = line + strspn(line, "# ");
        if (strncmp(at, key, length) == 0 && at[length] == ':') return at + length + 1;
    }
    return NULL;
}

static bool hash(uint64_t *value, const mukca_table *table, const char *key)
{
    const char *text = head(table, key);
    char *end = NULL;
    *value = text ? strtoull(text, &end, 16) : 0;
    return text && end == text + 17;
}

/* The number of arms stated before the header; 0: not stated. */
static int count_arms(mukca_table *table)
{
    const char *text = head(table, "arms");
    char *end = NULL;
    if (!text) return 0;
    const long n = strtol(text, &end, 10);
    if (end > text && end[strspn(end, " \t")] == '\n' && n >= 0 && n <= INT_MAX) return (int)n;
    table->line = 1;
    for (const char *c = table->comments; c < text; c++) table->line += *c == '\n';
    mukca_table_fail(table, -1, "`# arms:` is no number; make the table again with mukca fleet");
    return 0;
}

/* Check that the chain has the fleet's nominal geometry; joint names come from the chain. */
static void check_model(mukca_traits *t, mukca_table *table, const mukca_chain *chain)
{
    mukca_fleet_model present;
    mukca_fleet_model_of(&present, chain);
    t->model = present;
    const bool stated =
        hash(&t->model.geometry, table, "geometry") && hash(&t->model.masses, table, "masses");
    const char *differs = mukca_fleet_model_differs(&present, &t->model);
    if (!stated)
        mukca_table_fail(table, MUKCA_WHOLE_TABLE,
                         "no traits table: `# geometry:` or `# masses:` is missing; make it with "
                         "mukca fleet");
    else if (differs)
        mukca_table_fail(table, MUKCA_WHOLE_TABLE,
                         "traits of another model: %s; give those of this arm's model", differs);
    t->n_arms = count_arms(table);
}

static mukca_effect read_effect(mukca_table *table, const int *column, const mukca_chain *chain)
{
    const char *joint = table->cell[column[JOINT]], *term = table->cell[column[TERM]];
    const int kind = mukca_effect_find(table->cell[column[EFFECT]]);
    const bool order = mukca_effect_has(kind, MUKCA_TRAIT_ORDERS);
    mukca_effect e = {.kind = (mukca_effect_kind)kind, .joint = -1, .placement = -1};
    if (!order && !mukca_effect_has(kind, MUKCA_TRAIT_FLEXIBLE)) {
        mukca_table_fail(table, column[EFFECT],
                         "'%s' is no trait; joint_compliance, link_bending, base_compliance and "
                         "gear_harmonic are",
                         table->cell[column[EFFECT]]);
        return e;
    }
    if (mukca_effect_has_joint(kind)) {
        e.joint = mukca_chain_find_joint(chain, joint);
        if (e.joint < 0)
            mukca_table_fail(table, column[JOINT], "'%s' is no joint of the arm", joint);
    }
    if (order && (strncmp(term, "order=", 6) != 0 ||
                  mukca_effect_set_variant(&e, term + 6, chain->n_joints)))
        mukca_table_fail(table, column[TERM], "'%s' is not order=N, N from 2 to 400", term);
    e.terms = mukca_effect_terms(&e);
    return e;
}

static void read_row(mukca_traits *t, mukca_table *table, const int *column,
                     const mukca_chain *chain)
{
    mukca_trait r = {.effect = read_effect(table, column, chain),
                     .spread = NAN,
                     .error = NAN,
                     .value = NAN,
                     .low = NAN,
                     .high = NAN};
    const bool order = mukca_effect_has((int)r.effect.kind, MUKCA_TRAIT_ORDERS);
    for (int c = MEAN; c <= ERROR; c++) {
        if (order && (c == SPREAD || c == ERROR)) continue;
        const double value = mukca_table_number(table, column[c]);
        if (c == ARMS)
            r.arms = (int)fmin(fmax(value, 0), 1e9);
        else
            memcpy((char *)&r + columns[c].offset, &value, sizeof value);
    }
    if (!order && !(r.spread > 0 && r.error > 0 && r.mean >= 0))
        mukca_table_fail(table, column[r.mean >= 0 ? SPREAD : MEAN],
                         "a mean is at least 0, its spread and error are above 0");
    if (!(r.probability >= 0 && r.probability <= 1))
        mukca_table_fail(table, column[PROBABILITY], "not between 0 and 1");
    for (int i = 0; i < t->n; i++)
        if (mukca_effect_same(&t->list[i].effect, &r.effect))
            mukca_table_fail(table, column[EFFECT], "the same trait twice");
    if (t->n == MUKCA_MAX_TRAITS) mukca_table_fail(table, -1, "too many traits");
    if (table->status == MUKCA_OK) t->list[t->n++] = r;
}

mukca_status mukca_traits_read(mukca_traits *t, const char *path, const mukca_chain *chain,
                               mukca_error *error)
{
    mukca_table table;
    int column[ERROR + 1];
    memset(t, 0, sizeof *t);
    mukca_table_open(&table, path, MUKCA_HEADER, error);
    if (table.status == MUKCA_OK) check_model(t, &table, chain);
    for (int c = 0; c <= ERROR; c++)
        if (c != UNIT) column[c] = mukca_table_require(&table, columns[c].name);
    while (mukca_table_next(&table)) read_row(t, &table, column, chain);
    if (table.cut_off) mukca_table_fail(&table, -1, "the file is cut off; make it again");
    return mukca_table_close(&table);
}
