/* Reader of .lcm type descriptions: package, struct, const, comments; as lcm-gen accepts them. */
#include "lcm/description.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TOKEN_SIZE = 96, MAX_FILE = 1 << 20 };

typedef struct {
    const char *at, *end, *file;
    int line, column;             /* of `at` */
    int token_line, token_column; /* of `token` */
    char token[TOKEN_SIZE];       /* empty: end of the text */
    mukca_error *error;
} reader;

static mukca_status fail(const reader *r, const char *what)
{
    return mukca_fail(r->error, MUKCA_INPUT, "%s:%d:%d: %s%s%.60s%s", r->file, r->token_line,
                      r->token_column, what, r->token[0] ? " at \"" : " at the end", r->token,
                      r->token[0] ? "\"" : "");
}

static void advance(reader *r)
{
    if (*r->at == '\n') {
        r->line++;
        r->column = 1;
    } else {
        r->column++;
    }
    r->at++;
}

static bool starts(const reader *r, const char *two)
{
    return r->end - r->at >= 2 && r->at[0] == two[0] && r->at[1] == two[1];
}

static void skip_blank(reader *r)
{
    for (;;) {
        if (starts(r, "//")) {
            while (r->at < r->end && *r->at != '\n') advance(r);
        } else if (starts(r, "/*")) {
            while (r->at < r->end && !starts(r, "*/")) advance(r);
            for (int i = 0; i < 2 && r->at < r->end; i++) advance(r);
        } else if (r->at < r->end && isspace((unsigned char)*r->at)) {
            advance(r);
        } else {
            return;
        }
    }
}

static bool is_word(char c)
{
    return isalnum((unsigned char)c) || c == '_' || c == '.' || c == '-' || c == '+';
}

/* Next token: a word (name, number) or one other character. */
static mukca_status next(reader *r)
{
    skip_blank(r);
    r->token_line = r->line;
    r->token_column = r->column;
    size_t n = 0;
    if (r->at < r->end && !is_word(*r->at)) {
        r->token[n++] = *r->at;
        advance(r);
    }
    while (n < TOKEN_SIZE - 1 && (n == 0 || is_word(r->token[0])) && r->at < r->end &&
           is_word(*r->at)) {
        r->token[n++] = *r->at;
        advance(r);
    }
    r->token[n] = '\0';
    return n < TOKEN_SIZE - 1 ? MUKCA_OK : fail(r, "name too long");
}

static bool is(const reader *r, const char *text)
{
    return strcmp(r->token, text) == 0;
}

static mukca_status expect(reader *r, const char *text)
{
    char what[32];
    if (is(r, text)) return next(r);
    snprintf(what, sizeof what, "expected \"%s\"", text);
    return fail(r, what);
}

/* Copy the token, which must be a name (with dots where `dots`), and go on. */
static mukca_status take_name(reader *r, char *name, size_t size, bool dots)
{
    bool good = isalpha((unsigned char)r->token[0]) || r->token[0] == '_';
    for (const char *c = r->token; *c; c++)
        good = good && (isalnum((unsigned char)*c) || *c == '_' || (dots && *c == '.'));
    if (!good || strlen(r->token) >= size) return fail(r, "expected a name");
    memcpy(name, r->token, strlen(r->token) + 1);
    return next(r);
}

/* "[ size ]" of a field; `before` are the fields of the struct so far. */
static mukca_status parse_dimension(reader *r, mukca_lcm_field *field,
                                    const mukca_lcm_field *before, int n_before)
{
    if (field->n_dimensions == MUKCA_LCM_MAX_DIMENSIONS) return fail(r, "too many dimensions");
    mukca_lcm_dimension *d = &field->dimension[field->n_dimensions++];
    mukca_status status = next(r);
    if (status != MUKCA_OK) return status;
    if (strlen(r->token) >= sizeof d->text) return fail(r, "size too long");
    memcpy(d->text, r->token, strlen(r->token) + 1);
    d->field = -1;
    if (isdigit((unsigned char)r->token[0])) {
        char *end;
        long count = strtol(r->token, &end, 0);
        if (*end || count <= 0 || count > 1 << 20) return fail(r, "bad array size");
        d->count = (int)count;
    } else {
        for (int i = 0; i < n_before; i++)
            if (strcmp(before[i].name, r->token) == 0 && before[i].n_dimensions == 0 &&
                before[i].primitive <= MUKCA_LCM_INT64)
                d->field = i;
        if (d->field < 0) return fail(r, "the array size is no integer field before this one");
    }
    if ((status = next(r)) != MUKCA_OK) return status;
    return expect(r, "]");
}

/* "type name[..], name ... ;" */
static mukca_status parse_members(reader *r, mukca_lcm_types *types, mukca_lcm_type *type,
                                  const char *package)
{
    mukca_lcm_field form;
    char name[MUKCA_LCM_NAME_SIZE];
    memset(&form, 0, sizeof form);
    form.primitive = MUKCA_LCM_NESTED;
    mukca_status status = take_name(r, name, sizeof name, true);
    if (status != MUKCA_OK) return status;
    for (int p = 0; p < MUKCA_LCM_NESTED; p++)
        if (strcmp(name, mukca_lcm_primitive_names[p]) == 0)
            form.primitive = (mukca_lcm_primitive)p;
    if (form.primitive == MUKCA_LCM_NESTED) {
        bool whole = strchr(name, '.') || !package[0];
        int n = snprintf(form.nested_name, sizeof form.nested_name, "%s%s%s", whole ? "" : package,
                         whole ? "" : ".", name);
        if (n >= (int)sizeof form.nested_name) return fail(r, "type name too long before this");
    }
    for (;;) {
        if (type->n_fields == MUKCA_LCM_MAX_TYPE_FIELDS || types->n_fields == MUKCA_LCM_MAX_FIELDS)
            return fail(r, "too many fields");
        mukca_lcm_field *field = &types->field[types->n_fields];
        *field = form;
        if ((status = take_name(r, field->name, sizeof field->name, false)) != MUKCA_OK)
            return status;
        while (is(r, "["))
            if ((status =
                     parse_dimension(r, field, &types->field[type->first_field], type->n_fields)))
                return status;
        for (int i = 0; i < type->n_fields; i++)
            if (strcmp(types->field[type->first_field + i].name, field->name) == 0)
                return fail(r, "the same field twice, before this");
        types->n_fields++;
        type->n_fields++;
        if (!is(r, ",")) return expect(r, ";");
        if ((status = next(r)) != MUKCA_OK) return status;
    }
}

static mukca_status parse_struct(reader *r, mukca_lcm_types *types, const char *package)
{
    if (types->n_types == MUKCA_LCM_MAX_TYPES) return fail(r, "too many types");
    mukca_lcm_type *type = &types->type[types->n_types];
    char name[MUKCA_LCM_NAME_SIZE];
    memset(type, 0, sizeof *type);
    memset(type->role, -1, sizeof type->role);
    type->effort_factor = 1;
    type->first_field = types->n_fields;
    mukca_status status = take_name(r, name, sizeof name, false);
    if (status != MUKCA_OK) return status;
    int n = snprintf(type->name, sizeof type->name, "%s%s%s", package, package[0] ? "." : "", name);
    if (n >= (int)sizeof type->name) return fail(r, "type name too long before this");
    if ((status = expect(r, "{")) != MUKCA_OK) return status;
    while (!is(r, "}")) {
        if (is(r, "const")) { /* no part of the message */
            while (!is(r, ";") && r->token[0])
                if ((status = next(r)) != MUKCA_OK) return status;
            status = expect(r, ";");
        } else if (is(r, "enum") || is(r, "struct")) {
            status = fail(r, "enum and struct inside a struct are not understood");
        } else {
            status = parse_members(r, types, type, package);
        }
        if (status != MUKCA_OK) return status;
    }
    types->n_types++;
    return next(r);
}

mukca_status mukca_lcm_types_parse(mukca_lcm_types *types, const char *text, size_t length,
                                   const char *file, mukca_error *error)
{
    reader r = {.at = text, .end = text + length, .file = file, .line = 1, .column = 1};
    int n_types = types->n_types, n_fields = types->n_fields;
    char package[MUKCA_LCM_NAME_SIZE] = "";
    r.error = error;
    mukca_status status = next(&r);
    while (!status && r.token[0]) {
        if (is(&r, "package")) {
            if (!(status = next(&r)) && !(status = take_name(&r, package, sizeof package, true)))
                status = expect(&r, ";");
        } else if (is(&r, "struct")) {
            if (!(status = next(&r))) status = parse_struct(&r, types, package);
        } else if (is(&r, "enum")) {
            status = fail(&r, "enum is not understood (deprecated in LCM): use an int32_t field");
        } else {
            status = fail(&r, "expected \"package\" or \"struct\"");
        }
    }
    if (!status && types->n_types == n_types)
        status = mukca_fail(error, MUKCA_INPUT, "%s describes no struct", file);
    if (status == MUKCA_OK) status = mukca_lcm_types_link(types, n_types, file, error);
    if (status) {
        types->n_types = n_types;
        types->n_fields = n_fields;
    }
    return status;
}

mukca_status mukca_lcm_types_read(mukca_lcm_types *types, const char *path, mukca_error *error)
{
    mukca_status status;
    FILE *file = fopen(path, "rb");
    char *text = malloc(MAX_FILE);
    if (!text) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    } else if (!file) {
        status = mukca_fail(error, MUKCA_INPUT, "%s: cannot be read: check the path", path);
    } else {
        size_t length = fread(text, 1, MAX_FILE, file);
        if (ferror(file) || length == MAX_FILE)
            status = mukca_fail(error, MUKCA_INPUT, "%s: %s", path,
                                ferror(file) ? "cannot be read" : "too large for a description");
        else
            status = mukca_lcm_types_parse(types, text, length, path, error);
    }
    free(text);
    if (file) fclose(file);
    return status;
}
