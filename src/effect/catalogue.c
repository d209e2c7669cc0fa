/* The catalogue of effects: table and queries; text form of variants and terms; units. */
#include "effect/catalogue.h"

#include <string.h>

#include "base/number.h"
#include "math/sincos.h"

const mukca_effect_ops *const mukca_effect_catalogue[MUKCA_EFFECT_COUNT] = {
#define ROW(kind, name) &mukca_##name##_effect,
    MUKCA_EFFECT_LIST(ROW)
#undef ROW
};

const mukca_effect_info *const mukca_effect_table[MUKCA_EFFECT_COUNT] = {
#define ROW(kind, name) &mukca_##name##_effect.info,
    MUKCA_EFFECT_LIST(ROW)
#undef ROW
};

const char *const mukca_varies_name[MUKCA_VARIES_COUNT] = {
#define NAME(constant, name) name,
    MUKCA_VARIES_LIST(NAME)
#undef NAME
};

int mukca_effect_find(const char *name)
{
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++)
        if (!strcmp(mukca_effect_table[kind]->name, name)) return kind;
    return -1;
}

bool mukca_effect_has(int kind, int traits)
{
    return kind >= 0 && kind < MUKCA_EFFECT_COUNT &&
           (mukca_effect_table[kind]->traits & traits) != 0;
}

mukca_effect_kind mukca_effect_at(mukca_effect_site site, int traits)
{
    int kind = 0;
    while (kind + 1 < MUKCA_EFFECT_COUNT && (mukca_effect_table[kind]->site != site ||
                                             (mukca_effect_table[kind]->traits & traits) != traits))
        kind++;
    return (mukca_effect_kind)kind;
}

bool mukca_effect_has_joint(int kind)
{
    const mukca_effect_site site = mukca_effect_table[kind]->site;
    return site == MUKCA_SITE_ANGLE || site == MUKCA_SITE_ROTATION;
}

bool mukca_effect_is_smooth(const mukca_effect *effect)
{
    /* gravity torque has orders 1 and 2 in a joint's angle, up to 3 with a neighbour's */
    return mukca_effect_has((int)effect->kind, MUKCA_TRAIT_SMOOTH) && effect->variant.order <= 3;
}

bool mukca_effect_same(const mukca_effect *a, const mukca_effect *b)
{
    const mukca_effect_variant *x = &a->variant, *y = &b->variant;
    return a->kind == b->kind && a->joint == b->joint && a->placement == b->placement &&
           x->order == y->order && x->frame == y->frame && x->neighbour == y->neighbour &&
           x->torque_scale == y->torque_scale && x->time_constant == y->time_constant &&
           x->to_command == y->to_command;
}

int mukca_effect_terms(const mukca_effect *effect)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    if (!ops->variant_terms) return ops->info.terms;
    int terms = 0;
    while (ops->variant_terms(&effect->variant)[terms]) terms++;
    return terms;
}

void mukca_effect_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                        const double axis[3], const mukca_joint_state *state)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    static const double none[MUKCA_MAX_TERMS][3] = {{0}};
    double angle[2], sine[4], cosine[4];
    const mukca_basis_input in = {
        .effect = effect, .axis = axis, .state = state, .sine = sine, .cosine = cosine};
    memcpy(basis, none, sizeof none); /* for so few bytes memset is slower than most effects */
    if (ops->info.traits & MUKCA_TRAIT_PERIODIC) {
        angle[1] = state->q[effect->joint];
        angle[0] = (effect->variant.order ? effect->variant.order : 1) * angle[1];
        mukca_sincos(sine, cosine, angle, 2);
    }
    if (ops->basis) ops->basis(basis, &in);
}

void mukca_effect_direction(double *direction, int n_joints, const mukca_effect *effect,
                            const mukca_joint_state *state)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    memset(direction, 0, (size_t)n_joints * sizeof *direction);
    if (ops->direction) ops->direction(direction, n_joints, effect, state);
}

/* ---- candidates for a recording, and reasons why there are none ---- */

bool mukca_effect_candidate(mukca_effect *effect, mukca_effect_kind kind, int joint,
                            const mukca_effect_survey *survey, int i)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[kind];
    *effect = (mukca_effect){.kind = kind, .joint = joint, .placement = -1};
    if ((ops->info.traits & MUKCA_TRAIT_PERIODIC) && !survey->joint[joint].turns) return false;
    if ((ops->info.needs & MUKCA_NEEDS_COMMANDS) && !survey->by_command) return false;
    if (!ops->candidate || !ops->candidate(effect, survey, i)) return false;
    effect->terms = mukca_effect_terms(effect);
    return true;
}

int mukca_effect_kin(const mukca_effect *effect)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    const int gear = ops->gear ? ops->gear(effect->variant.order) : 0;
    return gear ? 1 + gear : (ops->info.traits & MUKCA_TRAIT_FLEXIBLE) != 0;
}

const char *mukca_effect_missing(mukca_effect_kind kind, const mukca_effect_survey *survey)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[kind];
    const int needs = ops->info.needs;
    if ((needs & MUKCA_NEEDS_COMMANDS) && !survey->by_command)
        return "the angles are readings; for commanded ones give --angles command";
    if (needs & MUKCA_NEEDS_MASSES) return "no link masses; give --inertials FILE";
    if ((needs & MUKCA_NEEDS_PLACEMENTS) && survey->sockets)
        return "one placement only; record a second one";
    if (needs & MUKCA_NEEDS_PLACEMENTS) return "a pose log has no placements";
    if ((needs & MUKCA_NEEDS_SOCKETS) && !survey->sockets) return "a pose log has no sockets";
    if (ops->missing) return ops->missing;
    return needs & MUKCA_NEEDS_ORDER ? "no joint moved between samples" : "no joint moved enough";
}

const char *mukca_effect_untested(mukca_effect_kind kind, const mukca_effect_survey *survey,
                                  int joint)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[kind];
    const bool loads = ops->info.needs & MUKCA_NEEDS_MASSES;
    if (loads && survey->joint[joint].torque_most < MUKCA_LEAST_TORQUE)
        return "no gravity torque about this joint in these postures";
    if (ops->untested) return ops->untested;
    if (survey->joint[joint].range < MUKCA_LEAST_RANGE)
        return "this joint did not move; record postures with a wider range of this joint";
    return "these samples do not depend on it";
}

const char *mukca_effect_faint(mukca_effect_kind kind, int joint)
{
    const char *at_first = mukca_effect_catalogue[kind]->faint_at_first;
    if (joint == 0 && at_first) return at_first;
    if (joint < 0) return "too small to detect with these samples; record more";
    return "has almost no effect on the tip in these postures; use a wider range of this joint, or "
           "mount ball or target off its axis";
}

/* ---- text form ---- */

const char *mukca_effect_set_variant(mukca_effect *effect, const char *text, int n_joints)
{
    const mukca_variant_ops *ops = mukca_effect_catalogue[effect->kind]->variant;
    effect->variant = ops && !text ? ops->usual : (mukca_effect_variant){0};
    if (!ops && text) return "no @";
    if (ops && (text ? !ops->read(&effect->variant, text) : ops->required)) return ops->expected;
    if (ops && ops->complete && !ops->complete(effect, n_joints)) return ops->expected;
    effect->terms = mukca_effect_terms(effect);
    return NULL;
}

void mukca_effect_variant_text(char text[MUKCA_EFFECT_TEXT], const mukca_effect *effect)
{
    const mukca_variant_ops *ops = mukca_effect_catalogue[effect->kind]->variant;
    text[0] = '\0';
    if (ops) ops->write(text, MUKCA_EFFECT_TEXT, &effect->variant);
}

/* Names of the terms; the first is NULL for a single term. */
static const char *const *term_names(const mukca_effect *effect)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    return ops->variant_terms ? ops->variant_terms(&effect->variant) : ops->term_name;
}

void mukca_effect_term_text(char text[MUKCA_EFFECT_TEXT], const mukca_effect *effect, int term)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    char word[MUKCA_EFFECT_TEXT], placement[24] = "";
    const char *key = ops->variant && ops->variant->key ? ops->variant->key : "";
    const char *name = term_names(effect)[0] ? term_names(effect)[term] : "";
    if (mukca_effect_has((int)effect->kind, MUKCA_TRAIT_PER_PLACEMENT))
        mukca_print(placement, sizeof placement, "placement=%d", effect->placement);
    mukca_effect_variant_text(word, effect);
    const bool any = placement[0] || word[0];
    mukca_print(text, MUKCA_EFFECT_TEXT, "%.24s%.16s%s%.20s%s%.8s", placement, key,
                key[0] ? "=" : "", word, any && name[0] ? " " : "", any || name[0] ? name : "-");
}

/* Copy the word at `text` up to the next space, after KEY= if a key is given; NULL: no such word.
 * Returns the start of the next one. */
static const char *take_word(char word[MUKCA_EFFECT_TEXT], const char *text, const char *key)
{
    const size_t prefix = key ? strlen(key) : 0;
    if (key && (strncmp(text, key, prefix) != 0 || text[prefix] != '=')) return NULL;
    if (key) text += prefix + 1;
    const size_t length = strcspn(text, " ");
    if (length == 0 || length >= MUKCA_EFFECT_TEXT) return NULL;
    memcpy(word, text, length);
    word[length] = '\0';
    text += length;
    return *text == ' ' ? text + 1 : text;
}

int mukca_effect_term_parse(mukca_effect *effect, const char *text, int n_joints)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    char word[MUKCA_EFFECT_TEXT];
    effect->placement = -1;
    effect->variant = (mukca_effect_variant){0};
    const bool placed = mukca_effect_has((int)effect->kind, MUKCA_TRAIT_PER_PLACEMENT);
    if (placed) {
        text = take_word(word, text, "placement");
        if (!text || !mukca_effect_read_integer(&effect->placement, word, -1, 1000000)) return -1;
    }
    if (ops->variant) {
        text = take_word(word, text, ops->variant->key);
        if (!text || mukca_effect_set_variant(effect, word, n_joints)) return -1;
    }
    effect->terms = mukca_effect_terms(effect);
    const char *const *names = term_names(effect);
    if (!names[0]) return strcmp(text, placed || ops->variant ? "" : "-") == 0 ? 0 : -1;
    for (int term = 0; term < effect->terms; term++)
        if (strcmp(text, names[term]) == 0) return term;
    return -1;
}

const char *mukca_effect_unit(const mukca_effect *effect, const mukca_chain *chain)
{
    /* revolute and prismatic joint */
    static const char *const pairs[][2] = {{"rad/(N*m)", "m/N"}, {"rad/rad", "m/m"}, {"rad", "m"}};
    const mukca_effect_info *info = mukca_effect_table[effect->kind];
    if (effect->variant.to_command) return "rad/rad";
    if (info->site != MUKCA_SITE_ANGLE || effect->joint < 0 ||
        chain->element[chain->joint_element[effect->joint]].type != MUKCA_PRISMATIC)
        return info->unit;
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++)
        if (strcmp(info->unit, pairs[i][0]) == 0) return pairs[i][1];
    return info->unit;
}
