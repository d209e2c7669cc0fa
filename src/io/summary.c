/* Summaries of recordings as files of JSON lines. */
#include "io/summary.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/text.h"

#define SCHEMA "mukca.summary/1"

/* A log Bayes factor is encoded in three characters, most significant first, as a number of quanta
 * above -32768. */
static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
enum { WIDTH = 3, ZERO = 32768, TEXT = WIDTH * MUKCA_FLEET_ORDERS };

static void encode(char text[TEXT + 1], const int16_t *ripple)
{
    for (int o = 0; o < MUKCA_FLEET_ORDERS; o++)
        for (int k = 0; k < WIDTH; k++)
            text[WIDTH * o + k] = digits[(ripple[o] + ZERO) >> (12 - 6 * k) & 63];
    text[TEXT] = '\0';
}

static bool decode(int16_t *ripple, const char *text)
{
    if (!text || strlen(text) != TEXT) return false;
    for (int o = 0; o < MUKCA_FLEET_ORDERS; o++) {
        int value = 0;
        for (int k = 0; k < WIDTH; k++, text++) {
            const char *digit = strchr(digits, *text);
            if (!digit) return false;
            value = 64 * value + (int)(digit - digits);
        }
        if (abs(value - ZERO) > INT16_MAX) return false;
        ripple[o] = (int16_t)(value - ZERO);
    }
    return true;
}

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

static bool read_name(char name[MUKCA_NAME_SIZE], const json_t *value)
{
    const char *text = json_string_value(value);
    if (!text || strlen(text) >= MUKCA_NAME_SIZE || !mukca_utf8_valid(text)) return false;
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

/* Read what a line holds; returns the key that is missing or damaged, NULL: none. */
static const char *read_keys(mukca_summary *s, const json_t *root)
{
    mukca_fleet_model *m = &s->model;
    const json_t *joints = json_object_get(root, "joints"),
                 *samples = json_object_get(root, "samples"),
                 *ripple = json_object_get(root, "ripple");
    const size_t n = json_array_size(joints);
    if (n < 1 || n > MUKCA_MAX_JOINTS) return "joints";
    m->n_joints = (int)n;
    for (size_t j = 0; j < n; j++) {
        if (!read_name(m->joint[j], json_array_get(joints, j))) return "joints";
        if (json_array_size(ripple) != n ||
            !decode(s->ripple[j], json_string_value(json_array_get(ripple, j))))
            return "ripple";
    }
    const struct {
        const char *key;
        char *name;
        uint64_t *hash;
    } texts[] = {{"robot", m->robot, NULL},
                 {"base", m->base, NULL},
                 {"tip", m->tip, NULL},
                 {"arm", s->arm, NULL},
                 {"geometry", NULL, &m->geometry},
                 {"masses", NULL, &m->masses},
                 {"recording", NULL, &s->data}};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        const json_t *value = json_object_get(root, texts[i].key);
        if (!(texts[i].name ? read_name(texts[i].name, value) : read_hash(texts[i].hash, value)))
            return texts[i].key;
    }
    if (!*s->arm) return "arm";
    if (!json_is_integer(samples) || json_integer_value(samples) < 1 ||
        json_integer_value(samples) > INT32_MAX)
        return "samples";
    s->samples = (int)json_integer_value(samples);
    s->sigma_m = json_number_value(json_object_get(root, "sigma_m"));
    if (!(s->sigma_m > 0)) return "sigma_m";
    const int terms = mukca_fleet_terms(m->n_joints), packed = mukca_fleet_packed(terms);
    if (!read_numbers(s->information, json_object_get(root, "information"), packed))
        return "information";
    return read_numbers(s->vector, json_object_get(root, "vector"), terms) ? NULL : "vector";
}

/* Reason why a line is no summary, in `text`; NULL: it is one.  A traits table has means without
 * their information matrices and cannot be pooled again. */
static const char *read_line(mukca_summary *s, char text[128], const char *line, size_t length)
{
    json_error_t wrong;
    json_t *root = json_loadb(line, length, JSON_REJECT_DUPLICATES, &wrong);
    const char *schema = json_string_value(json_object_get(root, "schema")), *reason = text;
    if (!root && strncmp(line, "# mukca ", 8) == 0 && strstr(line, " traits table")) {
        reason =
            "a traits table, which cannot be pooled again; give the summaries it was made from, "
            "or the file in which mukca fleet --partial joined them";
    } else if (!root) {
        reason = line[length - 1] == '\n'
                     ? "no summary; give the files of diagnose --summary or fleet --partial"
                     : "the file is cut off; write the summary again";
    } else if (!schema || strncmp(schema, "mukca.summary/", 14) != 0) {
        reason = "not a summary; use the files of diagnose --summary";
    } else if (strcmp(schema, SCHEMA) != 0) {
        reason = "of another version than " SCHEMA "; write the summary again (diagnose --summary)";
    } else {
        const char *key = read_keys(s, root);
        snprintf(text, 128,
                 "`%s` is missing or damaged; write the summary again (diagnose --summary)",
                 key ? key : "");
        if (!key) reason = NULL;
    }
    json_decref(root);
    return reason;
}

mukca_status mukca_summary_read(mukca_fleet *fleet, const char *path, mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    mukca_summary *s = calloc(1, sizeof *s);
    FILE *stream = fopen(path, "re");
    char *line = NULL, text[128];
    size_t size = 0;
    ssize_t length = 0;
    int number = 1;
    if (!stream) status = mukca_file_fail(error, path);
    for (; s && stream && status == MUKCA_OK; number++) {
        errno = 0;
        if ((length = getline(&line, &size, stream)) < 0) break;
        const char *reason = read_line(s, text, line, (size_t)length);
        s->path = path;
        status = reason ? mukca_fail(error, MUKCA_INPUT, "%s:%d: %s", path, number, reason)
                        : mukca_fleet_take(fleet, s, error);
    }
    if (!s || (length < 0 && errno == ENOMEM))
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %s", path);
    else if (length < 0 && ferror(stream))
        status = mukca_fail(error, MUKCA_INPUT, "%s: %s", path, strerror(errno));
    else if (length < 0 && number == 1)
        status = mukca_fail(error, MUKCA_INPUT, "%s: the file is empty", path);
    if (stream) fclose(stream);
    free(line);
    free(s);
    return status;
}
