/* The wording of a diagnosis: causes, amplitudes, verdict, caveat and remedy. */
#include "report/wording.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/text.h"

const char *mukca_wording_put(char text[MUKCA_WORDING], const char *format, ...)
{
    const size_t used = strlen(text);
    va_list args;
    va_start(args, format);
    vsnprintf(text + used, MUKCA_WORDING - used, format, args);
    va_end(args);
    mukca_utf8_mend(text + used); /* names of files */
    return text;
}

#define put mukca_wording_put /* short for this file */

bool mukca_wording_slides(const mukca_chain *chain, int joint)
{
    return joint >= 0 && chain->element[chain->joint_element[joint]].type == MUKCA_PRISMATIC;
}

bool mukca_wording_on_arm(const mukca_cause *cause)
{
    return mukca_effect_table[cause->effect.kind]->site != MUKCA_SITE_SOCKET;
}

/* ---- causes ---- */

/* Is it a link, which bends before its joint? */
static bool bends(const mukca_effect_info *info)
{
    return info->site == MUKCA_SITE_ROTATION && info->traits & MUKCA_TRAIT_FLEXIBLE;
}

const char *mukca_wording_effect(char text[MUKCA_WORDING], mukca_effect_kind kind,
                                 const char *joint)
{
    const mukca_effect_info *info = mukca_effect_table[kind];
    snprintf(text, MUKCA_WORDING, "%s%s%s", info->title,
             !joint        ? ""
             : bends(info) ? " before "
                           : " at ",
             joint ? joint : "");
    return text;
}

const char *mukca_wording_probability(char text[MUKCA_WORDING], double probability)
{
    text[0] = '\0';
    if (probability > 0.999) return put(text, "probability > 99.9 %%");
    return put(text, "probability %.*f %%", probability > 0.99 ? 1 : 0, 100 * probability);
}

/* Remedy of a cause that differs from that of its effect; NULL: none.  A tool is the same in all
 * placements: a difference means that it moved.  A load on the last link acts by the link's tilt
 * only, as does an error of the ball's seat. */
static const char *particular_remedy(const mukca_cause *cause, const mukca_diagnosed *r)
{
    const mukca_effect *e = &cause->effect;
    const mukca_effect_info *info = mukca_effect_table[e->kind];
    const bool sockets = r->data->n_sockets > 0;
    if (info->site == MUKCA_SITE_DISTANCE && e->placement >= 0)
        return "fasten the tool, check the joints for slip, and record this placement again";
    if (bends(info) && e->joint == r->chain->n_joints - 1 && sockets)
        return "check that the ball's neck is free of the socket in all postures, and the screws "
               "of the tool; compensate the error only then";
    return NULL;
}

/* Whether the causes increase the error on the test data and are therefore uncertain. */
static bool worsen(const mukca_diagnosis *d)
{
    return d->verdict == MUKCA_VERDICT_TIED && d->test_explained_m > d->test_geometry_m;
}

/* Whether the offsets table has the cause for other postures. */
static bool compensates(const mukca_cause *cause, const mukca_diagnosed *r)
{
    const mukca_effect_kind kind = cause->effect.kind;
    const bool weightless = r->chain->n_masses == 0;
    return !worsen(r->diagnosis) && !mukca_effect_of_history(kind) &&
           !(weightless && mukca_effect_table[kind]->needs & MUKCA_NEEDS_MASSES);
}

const char *mukca_wording_remedy(const mukca_cause *cause, const mukca_diagnosed *r)
{
    const char *particular = particular_remedy(cause, r);
    if (particular) return particular;
    const char *text = mukca_effect_table[cause->effect.kind]->remedy;
    if (!compensates(cause, r) && (!text || strstr(text, "compensate it")))
        return "inspect the part; the offsets table does not correct it";
    return text ? text : "compensate it with the offsets table; inspect the transmission";
}

/* ---- the verdict ---- */

/* Names the joints that share the remaining error about equally, or one joint with its range. */
const char *mukca_wording_unexplained(char text[MUKCA_WORDING], const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    int n = 0;
    while (n < d->n_where && d->where[n].share > 0.5 * d->where[0].share) n++;
    put(text, "unexplained structure");
    for (int i = 0; i < n; i++)
        put(text, "%s%s",
            i == 0      ? " at "
            : i + 1 < n ? ", "
                        : " and ",
            mukca_chain_joint_name(r->chain, d->where[i].joint));
    if (n == 1) {
        const bool slides = mukca_wording_slides(r->chain, d->where[0].joint);
        const double factor = slides ? 1e3 : 180 / M_PI;
        put(text, ", mainly from %.0f to %.0f %s", factor * d->where[0].range_rad[0],
            factor * d->where[0].range_rad[1], slides ? "mm" : "degrees");
    }
    return put(text, ": no effect of the catalogue describes it");
}

const char *mukca_wording_caveat(char text[MUKCA_WORDING], const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    if (d->verdict == MUKCA_VERDICT_UNTESTABLE || r->chain->n_masses) return text;
    const mukca_effect_kind spring = mukca_effect_at(MUKCA_SITE_ANGLE, MUKCA_TRAIT_FLEXIBLE);
    for (int i = 0; i < d->n_tested; i++)
        if (d->tested[i].effect == spring && d->tested[i].joint < 0 && !d->tested[i].testable)
            put(text,
                "Flexibility cannot be measured: the URDF has no link masses (give --inertials "
                "FILE).");
    bool smooth = false;
    for (int i = 0; i < d->n_causes; i++) smooth |= mukca_effect_is_smooth(&d->causes[i].effect);
    if (*text && smooth)
        put(text, " It is named beside each cause that it may be.");
    else if (*text && d->unexplained)
        put(text, " The unexplained structure may be flexibility.");
    return text;
}

int mukca_wording_steps(mukca_step steps[MUKCA_MAX_STEPS], const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    static const char *const all[] = {"geometry and tool motion", "geometry and the cause",
                                      "geometry and both causes", "geometry and all causes"};
    int n = 0, of_arm = 0, k = 0;
    for (int i = 0; i < d->n_causes; i++) of_arm += mukca_wording_on_arm(&d->causes[i]);
    steps[n++] = (mukca_step){"nominal model", d->nominal_m, d->test_nominal_m};
    steps[n++] = (mukca_step){"calibrated geometry", d->geometry_m, d->test_geometry_m};
    if (d->n_faults) steps[n++] = (mukca_step){"faulty samples excluded", d->faults_excused_m, NAN};
    for (int i = 0; i < d->n_causes; i++)
        if (mukca_wording_on_arm(&d->causes[i]) && ++k < of_arm)
            steps[n++] =
                (mukca_step){k == 1 ? "geometry and the first cause" : "and a further cause",
                             d->causes[i].rung_m, NAN};
    if (d->n_causes)
        steps[n++] =
            (mukca_step){all[of_arm < 3 ? of_arm : 3], d->explained_m, d->test_explained_m};
    if (d->structure_m < d->explained_m) /* if it reduces the error */
        steps[n++] = (mukca_step){"and unexplained structure", d->structure_m, NAN};
    steps[n++] = (mukca_step){"noise floor", d->noise_floor_m, NAN};
    return n;
}

/* "8 postures tell the base from joint_2": the alternatives of a finding that are split. */
static const char *put_split(char *text, const mukca_diagnosed *r)
{
    const mukca_next_poses *next = r->next;
    const mukca_alternative *a = r->diagnosis->findings[next->finding].alternatives;
    const int needed =
        next->plan.evidence_after >= MUKCA_PLAN_NAME ? next->plan.n_rows : next->plan.rows_to_name;
    if (needed <= 0 || next->plan.n_rows == 0)
        return put(text, "%s",
                   r->data->n_sockets == 0
                       ? "record other postures, or (deflection under load) the same ones "
                         "with another payload: give both logs, with --payload KG,KG"
                       : "record another placement, far from these, to split the findings");
    put(text, "mukca plan --for %d%s: %d postures tell ", next->finding + 1,
        needed > next->plan.n_rows ? " with more --rows" : "", needed);
    for (int k = 0; k < 2; k++) {
        const mukca_effect *e = &a[next->pair[k]].effect;
        put(text, "%s%s", k ? " from " : "",
            mukca_wording_effect(MUKCA_WORDS, e->kind, mukca_chain_joint_name(r->chain, e->joint)));
    }
    return text;
}

/* Whether a deflection under load contradicts the modelled load: no spring is among its
 * alternatives, or it yields against the load. */
static bool load_is_another(const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    bool another = false;
    for (int i = 0; i < d->n_findings; i++) {
        const mukca_finding *f = &d->findings[i];
        int springs = 0;
        for (int a = 0; a < f->n_alternatives; a++) springs += f->alternatives[a].listed;
        another |= f->group.family == MUKCA_VARIES_LOAD && f->n_alternatives > 0 &&
                   (!springs || f->coefficient.high < 0 || f->alternatives[0].amplitude.high < 0);
    }
    return another && r->chain->n_masses > 0;
}

const char *mukca_wording_next(char text[MUKCA_WORDING], const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    if (load_is_another(r))
        return put(text,
                   "check --gravity (is the arm on a wall or a ceiling?), the link masses and "
                   "the payload: the load may differ from the modelled one");
    if (d->n_findings && mukca_next_poses_need_readings(&d->findings[0]))
        return put(text,
                   "record readings and commands (columns JOINT and JOINT.command): they separate "
                   "servo sag from compliance");
    if (d->verdict != MUKCA_VERDICT_UNTESTABLE && !worsen(d) && r->next && r->next->finding >= 0)
        return put_split(text, r);
    const char *next =
        d->verdict == MUKCA_VERDICT_UNTESTABLE ? "record again as stated, then repeat the diagnosis"
        : d->verdict == MUKCA_VERDICT_UNKNOWN
            ? "inspect the transmission and the bearings of the joints concerned, and record more "
              "samples over their range"
        : worsen(d)
            ? "record more samples; until these decide, -o writes the geometry alone, which "
              "predicts the test data better"
        : d->n_faults ? "record the faulty samples again"
        : d->n_causes && !r->saved
            ? "-o offsets.tsv saves geometry and causes for fk, evaluate, compensate and export"
            : "";
    return put(text, "%s", next);
}
