/* Parser of .lcm type descriptions: package, struct, const, comments; as lcm-gen accepts them;
 * fingerprints as lcm-gen computes them. */
#include "lcm/type.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

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

/* Resolve nested types and compute fingerprints of the types from index `first` on; `file` is used
 * in messages.  Errors: MUKCA_INPUT (a nested type without description). */
static mukca_status link_types(mukca_lcm_types *types, int first, const char *file,
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

/* ---- the parser ---- */

enum { TOKEN_SIZE = 96 };

/* State of the parser.  After an error the token is empty and nothing more is read. */
typedef struct {
    const char *text, *at, *file;
    const char *token_at;   /* start of the token */
    char token[TOKEN_SIZE]; /* empty: end of the text */
    char package[MUKCA_LCM_NAME_SIZE];
    mukca_lcm_types *types;
    mukca_status status;
    mukca_error *error;
} reader;

static void fail(reader *r, const char *what)
{
    int line = 1, column = 1;
    if (r->status != MUKCA_OK) return;
    for (const char *c = r->text; c < r->token_at; c++) {
        column = *c == '\n' ? 1 : column + 1;
        line += *c == '\n';
    }
    const char *quote = r->token[0] ? "\"" : "";
    r->status = mukca_fail(r->error, MUKCA_INPUT, "%s:%d:%d: %s at %s%.60s%s", r->file, line,
                           column, what, quote, r->token[0] ? r->token : "the end", quote);
    r->token[0] = '\0';
    r->at += strlen(r->at);
}

static void skip_blank(reader *r)
{
    for (;;) {
        r->at += strspn(r->at, " \t\r\n\v\f");
        if (strncmp(r->at, "//", 2) == 0) {
            r->at += strcspn(r->at, "\n");
        } else if (strncmp(r->at, "/*", 2) == 0) {
            const char *end = strstr(r->at, "*/");
            r->at = end ? end + 2 : r->at + strlen(r->at);
        } else {
            return;
        }
    }
}

#define LETTERS "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_"
#define DIGITS "0123456789"

/* Read the next token: a word (name, number) or one other character. */
static void next(reader *r)
{
    skip_blank(r);
    r->token_at = r->at;
    const size_t word = strspn(r->at, LETTERS DIGITS ".-+"), n = word ? word : *r->at != '\0';
    const size_t kept = n < TOKEN_SIZE ? n : TOKEN_SIZE - 1;
    memcpy(r->token, r->at, kept);
    r->token[kept] = '\0';
    r->at += n;
    if (kept < n) fail(r, "name too long");
}

static bool is(const reader *r, const char *text)
{
    return strcmp(r->token, text) == 0;
}

/* Consume the token if it equals `text`. */
static bool consume(reader *r, const char *text)
{
    if (!is(r, text)) return false;
    next(r);
    return true;
}

static void expect(reader *r, const char *text)
{
    char what[32];
    snprintf(what, sizeof what, "expected \"%s\"", text);
    if (!consume(r, text)) fail(r, what);
}

/* Copy and consume the token, which must be a name (dots are allowed with `dots`). */
static void read_name(reader *r, char *name, size_t size, bool dots)
{
    const size_t n = strspn(r->token, dots ? LETTERS DIGITS "." : LETTERS DIGITS);
    const bool good = n && strchr(LETTERS, r->token[0]) && !r->token[n];
    if (!good || n >= size) {
        fail(r, "expected a name");
        return;
    }
    memcpy(name, r->token, n + 1);
    next(r);
}

/* Form "package.name". */
static void qualify(reader *r, char whole[MUKCA_LCM_NAME_SIZE], const char *name)
{
    const char *package = r->package;
    int n = snprintf(whole, MUKCA_LCM_NAME_SIZE, "%s%s%s", package, *package ? "." : "", name);
    if (n >= MUKCA_LCM_NAME_SIZE) fail(r, "type name too long before this");
}

/* Parse "[ size ]" of a field; `type` has the fields before it. */
static void parse_dimension(reader *r, mukca_lcm_field *field, const mukca_lcm_type *type)
{
    const mukca_lcm_field *before = &r->types->field[type->first_field];
    if (field->n_dimensions == MUKCA_LCM_MAX_DIMENSIONS) fail(r, "too many dimensions");
    next(r);
    if (strlen(r->token) >= sizeof field->dimension[0].text) fail(r, "size too long");
    if (r->status != MUKCA_OK) return;
    mukca_lcm_dimension *d = &field->dimension[field->n_dimensions++];
    memcpy(d->text, r->token, strlen(r->token) + 1);
    d->field = -1;
    if (strspn(r->token, DIGITS)) {
        char *end;
        long count = strtol(r->token, &end, 0);
        if (*end || count <= 0 || count > 1 << 20) fail(r, "bad array size");
        d->count = (int)count;
    } else {
        for (int i = 0; i < type->n_fields; i++)
            if (is(r, before[i].name) && before[i].n_dimensions == 0 &&
                before[i].primitive <= MUKCA_LCM_INT64)
                d->field = i;
        if (d->field < 0) fail(r, "the array size is no integer field before this one");
    }
    next(r);
    expect(r, "]");
}

/* Parse "name[..]", a field with the type of `form`. */
static void parse_field(reader *r, mukca_lcm_type *type, const mukca_lcm_field *form)
{
    mukca_lcm_types *types = r->types;
    mukca_lcm_field *field = &types->field[types->n_fields];
    if (type->n_fields == MUKCA_LCM_MAX_TYPE_FIELDS || types->n_fields == MUKCA_LCM_MAX_FIELDS) {
        fail(r, "too many fields");
        return;
    }
    *field = *form;
    read_name(r, field->name, sizeof field->name, false);
    while (is(r, "[")) parse_dimension(r, field, type);
    for (int i = 0; i < type->n_fields; i++)
        if (strcmp(types->field[type->first_field + i].name, field->name) == 0)
            fail(r, "the same field twice, before this");
    types->n_fields++;
    type->n_fields++;
}

/* Parse "type name[..], name ... ;". */
static void parse_members(reader *r, mukca_lcm_type *type)
{
    mukca_lcm_field form = {.primitive = 0};
    char name[MUKCA_LCM_NAME_SIZE] = "";
    read_name(r, name, sizeof name, true);
    while (form.primitive < MUKCA_LCM_NESTED &&
           strcmp(name, mukca_lcm_primitive_names[form.primitive]) != 0)
        form.primitive++;
    if (strchr(name, '.'))
        memcpy(form.nested_name, name, sizeof name);
    else if (form.primitive == MUKCA_LCM_NESTED)
        qualify(r, form.nested_name, name);
    do parse_field(r, type, &form);
    while (consume(r, ","));
    expect(r, ";");
}

static void parse_struct(reader *r)
{
    mukca_lcm_types *types = r->types;
    if (types->n_types == MUKCA_LCM_MAX_TYPES) {
        fail(r, "too many types");
        return;
    }
    mukca_lcm_type *type = &types->type[types->n_types];
    char name[MUKCA_LCM_NAME_SIZE] = "";
    memset(type, 0, sizeof *type);
    memset(type->role, -1, sizeof type->role);
    type->effort_factor = 1;
    type->first_field = types->n_fields;
    read_name(r, name, sizeof name, false);
    qualify(r, type->name, name);
    expect(r, "{");
    while (r->status == MUKCA_OK && !consume(r, "}")) {
        if (is(r, "const")) { /* constants are not part of the message */
            while (r->token[0] && !is(r, ";")) next(r);
            expect(r, ";");
        } else if (is(r, "enum") || is(r, "struct")) {
            fail(r, "enum and struct inside a struct are not understood");
        } else {
            parse_members(r, type);
        }
    }
    types->n_types++;
}

mukca_status mukca_lcm_types_parse(mukca_lcm_types *types, const char *text, const char *file,
                                   mukca_error *error)
{
    const int n_types = types->n_types, n_fields = types->n_fields;
    reader r = {.text = text, .at = text, .file = file, .types = types, .error = error};
    next(&r);
    while (r.token[0]) {
        if (consume(&r, "package")) {
            read_name(&r, r.package, sizeof r.package, true);
            expect(&r, ";");
        } else if (consume(&r, "struct")) {
            parse_struct(&r);
        } else if (is(&r, "enum")) {
            fail(&r, "enum is not understood (deprecated in LCM): use an int32_t field");
        } else {
            fail(&r, "expected \"package\" or \"struct\"");
        }
    }
    if (r.status == MUKCA_OK && types->n_types == n_types)
        r.status = mukca_fail(error, MUKCA_INPUT, "%s describes no struct", file);
    if (r.status == MUKCA_OK) r.status = link_types(types, n_types, file, error);
    if (r.status != MUKCA_OK) {
        types->n_types = n_types;
        types->n_fields = n_fields;
    }
    return r.status;
}

mukca_status mukca_lcm_types_read(mukca_lcm_types *types, const char *path, mukca_error *error)
{
    char *text;
    mukca_status status = mukca_file_read(&text, path, error);
    if (status == MUKCA_OK) status = mukca_lcm_types_parse(types, text, path, error);
    free(text);
    return status;
}
