/* Text form of effects: variants, terms in offsets tables, descriptions and units. */

#include <string.h>

#include "base/print.h"
#include "effect/catalogue.h"

const char *mukca_effect_set_variant(mukca_effect *effect, const char *text, int n_joints)
{
    const mukca_variant_ops *ops = mukca_effect_catalogue[effect->kind]->variant;
    effect->variant = (mukca_effect_variant){0};
    if (!ops && text) return "no @";
    if (ops && text && !ops->read(&effect->variant, text)) return ops->expected;
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

void mukca_effect_describe(char *text, size_t size, const mukca_effect *effect,
                           const mukca_chain *chain)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    text[0] = '\0';
    if (ops->describe) ops->describe(text, size, effect, chain);
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
