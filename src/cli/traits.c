/* Label of an arm, and output of a fleet's traits in a diagnosis. */
#include "cli/diagnose.h"

#include <libgen.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/text.h"
#include "report/wording.h"

/* Name of the arm's folder: `path` if it contains placements, else the folder that contains it. */
static bool folder_of(char name[MUKCA_NAME_SIZE], const char *path)
{
    char whole[PATH_MAX], socket[PATH_MAX + 16];
    struct stat about;
    if (!realpath(path, whole) || stat(whole, &about) != 0) return false;
    snprintf(socket, sizeof socket, "%s/hole_0.csv", whole);
    const bool placements = S_ISDIR(about.st_mode) && access(socket, F_OK) != 0;
    const char *folder = basename(placements ? whole : dirname(whole));
    if (!*folder || *folder == '/' || strlen(folder) >= MUKCA_NAME_SIZE) return false;
    memcpy(name, folder, strlen(folder) + 1);
    return true;
}

mukca_status cli_arm_label(cli_call *call, char label[MUKCA_NAME_SIZE], const char *given)
{
    char other[MUKCA_NAME_SIZE] = "";
    if (given) {
        if (!*given || strlen(given) >= MUKCA_NAME_SIZE || strpbrk(given, "\t\r\n"))
            return cli_fail(call, MUKCA_USAGE,
                            "--arm: the label must have 1 to 63 bytes and no tab or line feed");
        memcpy(label, given, strlen(given) + 1);
        return MUKCA_OK;
    }
    for (int i = 0; i < call->arguments.n; i++)
        if (!folder_of(i ? other : label, call->arguments.items[i]) ||
            (i && strcmp(other, label) != 0))
            return cli_fail(
                call, MUKCA_USAGE,
                "the data do not lie in one folder that could name the arm; give --arm NAME");
    return MUKCA_OK;
}

/* ---- screen ---- */

/* Log Bayes factor of 1 to 20, strong evidence (R. Kass, A. Raftery, J. Am. Stat. Assoc. 90,
 * 1995); weaker evidence is no contradiction. */
#define CONTRADICTION (-3.)

static void put_coefficient(mukca_text *text, const mukca_inherited *c, const mukca_chain *chain)
{
    char words[MUKCA_WORDING];
    const mukca_trait *t = c->trait;
    const double f = 1e6; /* urad per rad */
    mukca_wording_effect(words, t->effect.kind, mukca_chain_joint_name(chain, t->effect.joint));
    mukca_text_put(
        text, "%s, %.3g urad/(N·m) [%.3g, %.3g]; fleet %.3g ± %.2g; %.0f %% from this arm", words,
        f * c->value, f * c->low, f * c->high, f * t->mean, f * t->spread, 100 * c->own_share);
}

void cli_adoption_print(cli_call *call, const mukca_adoption *a, const mukca_diagnosis *d,
                        const mukca_chain *chain)
{
    char line[1024] = "";
    mukca_text text = MUKCA_TEXT(line);
    int shown = 0;
    if (a->traits->n == 0) {
        cli_say(call, "Fleet", "the traits table of %d arms is empty: they share nothing",
                a->traits->n_arms);
        return;
    }
    if (!a->adopted) {
        cli_say(call, "Fleet",
                a->log_evidence < CONTRADICTION
                    ? "the traits of %d arms contradict this arm's data (log Bayes factor %.1f) "
                      "and are not used. Are they of this model, and are the link masses right?"
                    : "the traits of %d arms explain this arm's data less well than its own fit "
                      "(log Bayes factor %.1f) and are not used",
                a->traits->n_arms, a->log_evidence);
        return;
    }
    cli_say(call, "Fleet",
            a->only ? "only the means of %d arms' traits, nothing elastic of this arm (log Bayes "
                      "factor %.1f against its own fit)"
                    : "the traits of %d arms are the prior; this arm's data agree (log Bayes "
                      "factor %.1f against its own fit)",
            a->traits->n_arms, a->log_evidence);
    for (int i = 0; i < a->n; i++) {
        const mukca_inherited *c = &a->list[i];
        if (!(c->trait->probability > 0.5)) continue; /* others only in the JSON */
        put_coefficient(&text, c, chain);
        cli_say(call, shown++ ? "" : "Elastic", "%s", line);
        line[text.used = 0] = '\0';
    }
    if (isfinite(d->applied_m))
        cli_say(call, "Error", "held out, with the traits %.3f mm (without %.3f mm)",
                1e3 * d->applied_m, 1e3 * d->explained_m);
    if (isfinite(d->test_geometry_m))
        cli_say(call, "", "test data, with the traits %.3f mm (without %.3f mm)",
                1e3 * d->test_applied_m, 1e3 * d->test_explained_m);
}

/* ---- JSON ---- */

json_t *cli_adoption_json(const mukca_adoption *a, const mukca_diagnosis *d,
                          const mukca_chain *chain)
{
    json_t *elastic = json_array(), *orders = json_array();
    for (int i = 0; i < a->n; i++) {
        const mukca_inherited *c = &a->list[i];
        const mukca_trait *t = c->trait;
        cli_json_append(elastic, KEY("effect", mukca_effect_table[t->effect.kind]->name),
                        KEY("joint", mukca_chain_joint_name(chain, t->effect.joint)),
                        FIELD(c, value), KEY("ci95", cli_json_interval(c->low, c->high)),
                        FIELD(t, mean), FIELD(t, spread), FIELD(t, probability),
                        FIELD(c, own_share));
    }
    for (int i = 0; i < a->traits->n; i++) {
        const mukca_effect *e = &a->traits->list[i].effect;
        if (!mukca_effect_has((int)e->kind, MUKCA_TRAIT_ORDERS)) continue;
        cli_json_append(orders, KEY("joint", mukca_chain_joint_name(chain, e->joint)),
                        KEY("order", e->variant.order),
                        KEY("probability", a->traits->list[i].probability));
    }
    return cli_json(KEY("log_bayes_factor", a->log_evidence), KEY("explained_m", d->applied_m),
                    KEY("without_m", d->explained_m), KEY("test_explained_m", d->test_applied_m),
                    KEY("test_without_m", d->test_explained_m), KEY("used", a->adopted),
                    FIELD(a, only), KEY("arms", a->traits->n_arms), KEY("effects", elastic),
                    KEY("orders", orders));
}
