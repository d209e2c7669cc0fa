/* LCM message types: fingerprints as lcm-gen computes them, and roles of fields. */
#include "lcm/type.h"

#include <string.h>

#include "base/text.h"

#define PRIMITIVE_NAME(name, text, size) text,
#define PRIMITIVE_SIZE(name, text, size) size,
const char *const mukca_lcm_primitive_names[] = {MUKCA_LCM_PRIMITIVE_LIST(PRIMITIVE_NAME)};
const unsigned char mukca_lcm_primitive_sizes[] = {MUKCA_LCM_PRIMITIVE_LIST(PRIMITIVE_SIZE)};

/* ---- fingerprints: the algorithm of lcm-gen's C backend (emit_c.c, lcmgen.c) ---- */

static uint64_t hash_char(uint64_t hash, char c)
{
    /* lcm-gen shifts a signed number to the right, with sign extension */
    uint64_t high = hash >> 55 | (hash >> 63 ? ~(uint64_t)0 << 9 : 0);
    return (hash << 8 ^ high) + (uint64_t)(int64_t)c;
}

static uint64_t hash_text(uint64_t hash, const char *text)
{
    hash = hash_char(hash, (char)strlen(text));
    for (; *text; text++) hash = hash_char(hash, *text);
    return hash;
}

/* Fingerprint of a type: the hash of its own fields plus the fingerprints of nested types,
 * rotated left by one bit.  A type nested in itself adds 0.  `budget` limits the number of fields
 * visited. */
static uint64_t fingerprint(const mukca_lcm_types *types, int t, const int *parents, int depth,
                            int *budget)
{
    int chain[MUKCA_LCM_MAX_TYPES + 1];
    for (int i = 0; i < depth; i++)
        if ((chain[i] = parents[i]) == t) return 0;
    chain[depth] = t;
    const mukca_lcm_type *type = &types->type[t];
    uint64_t hash = 0x12345678, nested = 0;
    for (int i = 0; i < type->n_fields; i++) {
        const mukca_lcm_field *field = &types->field[type->first_field + i];
        if (--*budget < 0) return 0;
        hash = hash_text(hash, field->name);
        if (field->primitive != MUKCA_LCM_NESTED)
            hash = hash_text(hash, mukca_lcm_primitive_names[field->primitive]);
        else
            nested += fingerprint(types, field->nested, chain, depth + 1, budget);
        hash = hash_char(hash, (char)field->n_dimensions);
        for (int d = 0; d < field->n_dimensions; d++) {
            hash = hash_char(hash, field->dimension[d].field < 0 ? 0 : 1);
            hash = hash_text(hash, field->dimension[d].text);
        }
    }
    hash += nested;
    return hash << 1 | hash >> 63;
}

int mukca_lcm_types_find_name(const mukca_lcm_types *types, const char *name)
{
    for (int t = types->n_types - 1; t >= 0; t--)
        if (strcmp(types->type[t].name, name) == 0) return t;
    return -1;
}

mukca_status mukca_lcm_types_link(mukca_lcm_types *types, int first, const char *file,
                                  mukca_error *error)
{
    for (int t = first; t < types->n_types; t++)
        for (int i = 0; i < types->type[t].n_fields; i++) {
            mukca_lcm_field *field = &types->field[types->type[t].first_field + i];
            if (field->primitive != MUKCA_LCM_NESTED) continue;
            field->nested = mukca_lcm_types_find_name(types, field->nested_name);
            if (field->nested < 0)
                return mukca_fail(error, MUKCA_INPUT,
                                  "%s: field %s of %s is a %s, which neither this file nor an "
                                  "earlier --type describes; give its file first",
                                  file, field->name, types->type[t].name, field->nested_name);
        }
    for (int t = first; t < types->n_types; t++) {
        int budget = 100000;
        types->type[t].fingerprint = fingerprint(types, t, NULL, 0, &budget);
        if (budget < 0)
            return mukca_fail(error, MUKCA_INPUT, "%s: %s nests too many types", file,
                              types->type[t].name);
    }
    return MUKCA_OK;
}

/* ---- roles ---- */

static int find_field(const mukca_lcm_types *types, int t, const char *name, size_t length)
{
    for (int i = 0; i < types->type[t].n_fields; i++) {
        const char *field = types->field[types->type[t].first_field + i].name;
        if (strncmp(field, name, length) == 0 && field[length] == '\0') return i;
    }
    return -1;
}

/* Fail for an unknown field; the error lists the known ones. */
static mukca_status no_field(const mukca_lcm_types *types, int t, const char *name,
                             mukca_error *error)
{
    char fields[120] = "";
    mukca_text list = MUKCA_TEXT(fields);
    const mukca_lcm_type *type = &types->type[t];
    for (int i = 0; i < type->n_fields; i++)
        mukca_text_put(&list, " %s", types->field[type->first_field + i].name);
    return mukca_fail(error, MUKCA_INPUT, "%s has no field \"%.*s\"; its fields:%s", type->name,
                      (int)strcspn(name, "."), name, fields);
}

mukca_status mukca_lcm_type_set_role(mukca_lcm_types *types, int type, mukca_lcm_role role,
                                     const char *path, mukca_error *error)
{
    signed char found[MUKCA_LCM_MAX_DEPTH + 1];
    int t = type;
    for (int depth = 0; depth < MUKCA_LCM_MAX_DEPTH; depth++) {
        size_t length = strcspn(path, ".");
        int i = find_field(types, t, path, length);
        if (i < 0) return no_field(types, t, path, error);
        const mukca_lcm_field *field = &types->field[types->type[t].first_field + i];
        found[depth] = (signed char)i;
        if (path[length] == '.' && field->primitive == MUKCA_LCM_NESTED) {
            t = field->nested;
            path += length + 1;
            continue;
        }
        bool text = field->primitive == MUKCA_LCM_STRING;
        if (path[length] == '.' || field->primitive == MUKCA_LCM_NESTED ||
            text != (role == MUKCA_LCM_ROLE_NAME))
            return mukca_fail(
                error, MUKCA_INPUT, "field %s of %s is %s", field->name, types->type[t].name,
                field->primitive == MUKCA_LCM_NESTED ? "a struct: name a field of it, as in head.q"
                : text                               ? "a text, not a number"
                                                     : "a number, not a text or a struct");
        found[depth + 1] = -1;
        memcpy(types->type[type].role[role], found, (size_t)depth + 2);
        return MUKCA_OK;
    }
    return mukca_fail(error, MUKCA_INPUT, "a field more than %d structs deep", MUKCA_LCM_MAX_DEPTH);
}
