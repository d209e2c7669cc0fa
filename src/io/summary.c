/* Summaries of recordings as files of JSON lines. */
#include "io/summary.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"
#include "mukca/version.h"

#define SCHEMA "mukca.summary/1"

/* A log Bayes factor is encoded in three characters, most significant first, as a number of quanta
 * above -32768. */
static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
enum { WIDTH = 3, ZERO = 32768, TEXT = WIDTH * MUKCA_FLEET_ORDERS };

static void encode(char text[TEXT + 1], const int16_t *ripple)
{
    for (int o = 0; o < MUKCA_FLEET_ORDERS; o++) {
        const int value = ripple[o] + ZERO;
        text[WIDTH * o] = digits[value >> 12 & 63];
        text[WIDTH * o + 1] = digits[value >> 6 & 63];
        text[WIDTH * o + 2] = digits[value & 63];
    }
    text[TEXT] = '\0';
}

static int value_of(char c)
{
    return c >= 'A' && c <= 'Z'   ? c - 'A'
           : c >= 'a' && c <= 'z' ? c - 'a' + 26
           : c >= '0' && c <= '9' ? c - '0' + 52
           : c == '+'             ? 62
           : c == '/'             ? 63
                                  : -1;
}

static bool decode(int16_t *ripple, const char *text)
{
    if (strlen(text) != TEXT) return false;
    for (int o = 0; o < MUKCA_FLEET_ORDERS; o++, text += WIDTH) {
        const int high = value_of(text[0]), middle = value_of(text[1]), low = value_of(text[2]);
        const int value = (high * 4096 + middle * 64 + low) - ZERO;
        if (high < 0 || middle < 0 || low < 0 || abs(value) > INT16_MAX) return false;
        ripple[o] = (int16_t)value;
    }
    return true;
}

/* ---- writing ---- */

static json_t *text_of(const char *text)
{
    char mended[MUKCA_NAME_SIZE];
    snprintf(mended, sizeof mended, "%s", text);
    mukca_utf8_mend(mended);
    return json_string(mended);
}

static json_t *hash_of(uint64_t hash)
{
    return json_sprintf("%016" PRIx64, hash);
}

static json_t *numbers_of(const double *x, int n)
{
    json_t *array = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(array, json_real(x[i]));
    return array;
}

mukca_status mukca_summary_write(FILE *stream, const mukca_summary *s, mukca_error *error)
{
    const int n = s->model.n_joints, terms = mukca_fleet_terms(n);
    json_t *joints = json_array(), *ripple = json_array();
    for (int j = 0; j < n; j++) {
        char text[TEXT + 1];
        encode(text, s->ripple[j]);
        json_array_append_new(joints, text_of(s->model.joint[j]));
        json_array_append_new(ripple, json_string(text));
    }
    json_t *root = json_pack(
        "{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:o, s:o, s:o, s:o}", "schema", SCHEMA,
        "robot", text_of(s->model.robot), "base", text_of(s->model.base), "tip",
        text_of(s->model.tip), "joints", joints, "geometry", hash_of(s->model.geometry), "masses",
        hash_of(s->model.masses), "arm", text_of(s->arm), "recording", hash_of(s->data), "samples",
        s->samples, "sigma_m", json_real(s->sigma_m), "information",
        numbers_of(s->information, mukca_fleet_packed(terms)), "vector",
        numbers_of(s->vector, terms), "ripple", ripple);
    const bool ok = root && json_dumpf(root, stream, JSON_COMPACT | JSON_REAL_PRECISION(17)) == 0 &&
                    fputc('\n', stream) != EOF;
    json_decref(root);
    return ok ? MUKCA_OK : mukca_fail(error, MUKCA_MEMORY, "the summary cannot be written whole");
}

/* ---- reading ---- */

/* Position in a file, for error messages. */
typedef struct {
    const char *path;
    int line;
    mukca_error *error;
} place;

static mukca_status fail(const place *at, const char *what)
{
    return mukca_fail(at->error, MUKCA_INPUT,
                      "%s:%d: %s; write the summary again (diagnose --summary)", at->path, at->line,
                      what);
}

static bool read_name(char name[MUKCA_NAME_SIZE], const json_t *value)
{
    const char *text = json_string_value(value);
    if (!text || strlen(text) >= MUKCA_NAME_SIZE) return false;
    memcpy(name, text, strlen(text) + 1);
    return true;
}

static bool read_hash(uint64_t *hash, const json_t *value)
{
    const char *text = json_string_value(value);
    if (!text || strlen(text) != 16 || strspn(text, "0123456789abcdef") != 16) return false;
    *hash = strtoull(text, NULL, 16);
    return true;
}

/* JSON lacks infinity; the bound also keeps sums of these numbers finite. */
static bool read_numbers(double *x, const json_t *array, int n)
{
    const double most = 1e60;
    if (!json_is_array(array) || json_array_size(array) != (size_t)n) return false;
    for (int i = 0; i < n; i++) {
        const json_t *value = json_array_get(array, (size_t)i);
        x[i] = json_number_value(value);
        if (!json_is_number(value) || !(fabs(x[i]) < most)) return false;
    }
    return true;
}

static mukca_status read_model(mukca_fleet_model *m, const json_t *root, const place *at)
{
    const json_t *joints = json_object_get(root, "joints");
    const size_t n = json_array_size(joints);
    if (n < 1 || n > MUKCA_MAX_JOINTS) return fail(at, "`joints` is missing or has no usable size");
    m->n_joints = (int)n;
    for (size_t j = 0; j < n; j++)
        if (!read_name(m->joint[j], json_array_get(joints, j)))
            return fail(at, "`joints` contains something other than names");
    if (!read_name(m->robot, json_object_get(root, "robot")) ||
        !read_name(m->base, json_object_get(root, "base")) ||
        !read_name(m->tip, json_object_get(root, "tip")))
        return fail(at, "`robot`, `base` or `tip` is missing");
    if (!read_hash(&m->geometry, json_object_get(root, "geometry")) ||
        !read_hash(&m->masses, json_object_get(root, "masses")))
        return fail(at, "`geometry` or `masses` is no hash of 16 hexadecimal digits");
    return MUKCA_OK;
}

static mukca_status read_summary(mukca_summary *s, const json_t *root, const place *at)
{
    const char *schema = json_string_value(json_object_get(root, "schema"));
    memset(s, 0, sizeof *s);
    if (!schema || strncmp(schema, "mukca.summary/", 14) != 0)
        return mukca_fail(at->error, MUKCA_INPUT,
                          "%s:%d: not a summary; use the files of diagnose --summary", at->path,
                          at->line);
    if (strcmp(schema, SCHEMA) != 0) return fail(at, "of another version than " SCHEMA);
    mukca_status status = read_model(&s->model, root, at);
    if (status != MUKCA_OK) return status;
    const int n = s->model.n_joints, terms = mukca_fleet_terms(n);
    const json_t *samples = json_object_get(root, "samples"),
                 *ripple = json_object_get(root, "ripple");
    if (!read_name(s->arm, json_object_get(root, "arm")) || !*s->arm)
        return fail(at, "`arm` is missing or longer than 63 bytes");
    if (!read_hash(&s->data, json_object_get(root, "recording")))
        return fail(at, "`recording` is no hash of 16 hexadecimal digits");
    if (!json_is_integer(samples) || json_integer_value(samples) < 1 ||
        json_integer_value(samples) > INT32_MAX)
        return fail(at, "`samples` is no count");
    s->samples = (int)json_integer_value(samples);
    s->sigma_m = json_number_value(json_object_get(root, "sigma_m"));
    if (!(s->sigma_m > 0)) return fail(at, "`sigma_m` is not above 0");
    if (!read_numbers(s->information, json_object_get(root, "information"),
                      mukca_fleet_packed(terms)))
        return fail(at,
                    "`information` does not match the number of joints, or contains "
                    "something other than finite numbers");
    if (!read_numbers(s->vector, json_object_get(root, "vector"), terms))
        return fail(at,
                    "`vector` does not match the number of joints, or contains something "
                    "other than finite numbers");
    for (int j = 0; j < n; j++) {
        const char *text = json_string_value(json_array_get(ripple, (size_t)j));
        if (!text || json_array_size(ripple) != (size_t)n || !decode(s->ripple[j], text))
            return fail(at, "`ripple` is damaged");
    }
    return MUKCA_OK;
}

/* Refuse a line that is not JSON.  A traits table has means without their information matrices and
 * cannot be pooled again. */
static mukca_status refuse_line(const char *line, size_t length, const place *at)
{
    if (strncmp(line, "# mukca ", 8) == 0 && strstr(line, " traits table"))
        return mukca_fail(
            at->error, MUKCA_INPUT,
            "%s:%d: a traits table, which cannot be pooled again; give the summaries "
            "it was made from, or the file in which mukca fleet --partial joined them",
            at->path, at->line);
    return mukca_fail(at->error, MUKCA_INPUT, "%s:%d: %s; write the summary again", at->path,
                      at->line, line[length - 1] == '\n' ? "no JSON" : "the file is cut off");
}

mukca_status mukca_summary_read_stream(FILE *stream, const char *path, mukca_summary_fn *take,
                                       void *context, mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    mukca_summary *s = malloc(sizeof *s);
    char *line = NULL;
    size_t size = 0;
    place at = {.path = path, .error = error};
    if (!s) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %s", path);
    while (status == MUKCA_OK) {
        json_error_t wrong;
        errno = 0;
        const ssize_t length = getline(&line, &size, stream);
        if (length < 0) {
            if (errno == ENOMEM)
                status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %s", path);
            else if (ferror(stream))
                status = mukca_fail(error, MUKCA_INPUT, "%s: %s", path, strerror(errno));
            else if (at.line == 0)
                status = mukca_fail(error, MUKCA_INPUT, "%s: the file is empty", path);
            break;
        }
        at.line++;
        json_t *root = json_loadb(line, (size_t)length, JSON_REJECT_DUPLICATES, &wrong);
        if (root)
            status = read_summary(s, root, &at);
        else
            status = refuse_line(line, (size_t)length, &at);
        json_decref(root);
        if (status == MUKCA_OK) status = take(context, s, error);
    }
    free(line);
    free(s);
    return status;
}

mukca_status mukca_summary_read(const char *path, mukca_summary_fn *take, void *context,
                                mukca_error *error)
{
    FILE *stream = fopen(path, "re");
    if (!stream)
        return mukca_fail(error, MUKCA_INPUT, "%s: cannot read: %s", path, strerror(errno));
    const mukca_status status = mukca_summary_read_stream(stream, path, take, context, error);
    fclose(stream);
    return status;
}
