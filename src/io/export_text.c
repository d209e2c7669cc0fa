/* Helpers shared by the export formats: provenance, numbers, names and the calibrated origin. */
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "base/file.h"
#include "base/number.h"
#include "base/suggest.h"
#include "io/export.h"
#include "mukca/version.h"

static void print_quoted(FILE *stream, const char *text)
{
    fputc('"', stream);
    for (; *text; text++) {
        if ((unsigned char)*text < ' ') continue;
        if (*text == '"' || *text == '\\') fputc('\\', stream);
        fputc(*text, stream);
    }
    fputc('"', stream);
}

static void print_escaped(FILE *stream, const char *text)
{
    for (; *text; text++)
        if (*text == '&')
            fputs("&amp;", stream);
        else if (*text == '<')
            fputs("&lt;", stream);
        else if (*text == '"')
            fputs("&quot;", stream);
        else
            fputc((unsigned char)*text < ' ' ? ' ' : *text, stream);
}

static void print_plain(FILE *stream, const char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text < ' ' || (text[0] == '*' && text[1] == '/'))
            fputc(' ', stream);
        else
            fputc(text[0] == '-' && text[1] == '-' ? '_' : *text, stream);
}

static void print_number(FILE *stream, double value)
{
    char text[MUKCA_NUMBER_SIZE];
    mukca_number_format(text, value);
    fputs(isfinite(value) ? text : value < 0 ? "-HUGE_VAL" : "HUGE_VAL", stream);
}

void mukca_export_print(FILE *stream, const char *format, ...)
{
    va_list args;
    const double *values;
    const signed char *list;
    int n;
    va_start(args, format);
    for (const char *c = format; *c; c++) {
        if (*c != '$') {
            fputc(*c, stream);
            continue;
        }
        switch (*++c) {
            case 'i':
                fprintf(stream, "%d", va_arg(args, int));
                break;
            case 's':
                fputs(va_arg(args, const char *), stream);
                break;
            case 'q':
                print_quoted(stream, va_arg(args, const char *));
                break;
            case 'x':
                print_escaped(stream, va_arg(args, const char *));
                break;
            case 'p':
                print_plain(stream, va_arg(args, const char *));
                break;
            case 'n':
                print_number(stream, va_arg(args, double));
                break;
            case 'l':
                list = va_arg(args, const signed char *);
                n = va_arg(args, int);
                for (int i = 0; i < n; i++) fprintf(stream, i ? ", %d" : "%d", list[i]);
                break;
            default:
                values = va_arg(args, const double *);
                n = va_arg(args, int);
                for (int i = 0; i < n; i++) {
                    if (i) fputs(*c == 'c' ? ", " : " ", stream);
                    print_number(stream, values[i]);
                }
        }
    }
    va_end(args);
}

void mukca_export_provenance(FILE *stream, const char *prefix, const mukca_export_input *input)
{
    char when[32];
    mukca_offsets_time(when);
    mukca_export_print(stream, "$sWritten by mukca " MUKCA_VERSION " on $s from $p", prefix, when,
                       mukca_file_name(input->urdf_path));
    if (input->offsets_path)
        mukca_export_print(stream, " and $p", mukca_file_name(input->offsets_path));
    mukca_export_print(stream, ".\n$sRobot $p, from link $p to $p.\n$sSHA-256 of the URDF: $s\n",
                       prefix, input->chain->robot, input->chain->base, input->chain->tip, prefix,
                       input->chain->urdf_sha256);
}

void mukca_export_get_origin(mukca_export_origin *origin, const mukca_export_input *input,
                             int element)
{
    /* m or rad: three orders of magnitude below any arm's repeatability */
    const double smallest_offset = 1e-9;
    /* ten times half an ulp of 1: the rounding error of cos(pi / 2) */
    const double smallest_component = 1e-15;
    const mukca_element *nominal = &input->chain->element[element];
    const double *theta = input->offsets->theta + MUKCA_PARAMETERS * element;
    double R[9];
    origin->moved = false;
    memcpy(origin->xyz, nominal->xyz, sizeof origin->xyz);
    memcpy(origin->rpy, nominal->rpy, sizeof origin->rpy);
    for (int i = 0; i < MUKCA_PARAMETERS; i++) {
        if (fabs(theta[i] - origin->theta[i]) < smallest_offset) continue;
        origin->theta[i] = theta[i];
        origin->moved = true;
    }
    mukca_rotation_from_rpy(R, origin->rpy);
    mukca_rotation_to_quaternion(origin->quaternion, R);
    for (int i = 0; i < 4; i++)
        if (fabs(origin->quaternion[i]) < smallest_component) origin->quaternion[i] = 0;
}

/* ---- XML ---- */

/* After the comment, section or instruction at `at`, else after its `<`. */
static const char *skip(const char *at)
{
    static const char *const skipped[][2] = {{"<!--", "-->"}, {"<![CDATA[", "]]>"}, {"<?", "?>"}};
    for (int i = 0; i < 3; i++) {
        const char *end = strncmp(at, skipped[i][0], strlen(skipped[i][0])) == 0
                              ? strstr(at, skipped[i][1])
                              : NULL;
        if (end) return end;
    }
    return at + 1;
}

bool mukca_export_is_tag(const mukca_export_tag *tag, const char *name)
{
    const size_t length = strlen(name);
    return strncmp(tag->at + 1, name, length) == 0 && strchr(" \t\r\n/>", tag->at[1 + length]);
}

bool mukca_export_next_tag(mukca_export_tag *tag, const char *name)
{
    const char *at = tag->at + tag->length;
    while ((at = strchr(at, '<'))) {
        const char *start = at;
        at = skip(at);
        if (at > start + 1) continue;
        for (char quote = '\0'; *at && (quote || *at != '>'); at++)
            if (quote ? *at == quote : *at == '"' || *at == '\'') quote = quote ? '\0' : *at;
        if (!*at) return false;
        if (start[1] == '/') {
            tag->open--;
            continue;
        }
        tag->depth = tag->open;
        tag->open += at[-1] != '/';
        tag->at = start;
        tag->length = (size_t)(at + 1 - start);
        if (!name || mukca_export_is_tag(tag, name)) return true;
    }
    return false;
}

bool mukca_export_find_below(mukca_export_tag *tag, const mukca_export_tag *of, const char *kind)
{
    if (of->at[of->length - 2] == '/') return false;
    for (*tag = *of; mukca_export_next_tag(tag, NULL) && tag->depth > of->depth;)
        if (tag->depth == of->depth + 1 && mukca_export_is_tag(tag, kind)) return true;
    return false;
}

const char *mukca_export_find_attribute(size_t *length, const mukca_export_tag *tag,
                                        const char *name)
{
    const char *stop = tag->at + tag->length;
    for (const char *at = tag->at + strcspn(tag->at, " \t\r\n/>"), *end; at < stop; at = end + 1) {
        at += strspn(at, " \t\r\n");
        const size_t name_length = strcspn(at, " \t\r\n=/>");
        const char *quote = at + name_length + strspn(at + name_length, " \t\r\n=");
        end = name_length && *quote ? strchr(quote + 1, *quote) : NULL;
        if (!end || end >= stop) return NULL;
        *length = (size_t)(end - quote - 1);
        if (name_length == strlen(name) && strncmp(at, name, name_length) == 0) return quote + 1;
    }
    return NULL;
}

bool mukca_export_read_numbers(double *values, int n, const mukca_export_tag *tag, const char *name)
{
    char words[256];
    size_t length;
    const char *text = mukca_export_find_attribute(&length, tag, name);
    if (!text) return true;
    snprintf(words, sizeof words, "%.*s", (int)length, text);
    return length < sizeof words && mukca_number_parse_list(values, n, words);
}

bool mukca_export_read_pose(mukca_frame *pose, const mukca_export_tag *tag)
{
    double quat[4] = {1, 0, 0, 0};
    memset(pose, 0, sizeof *pose);
    const bool ok = mukca_export_read_numbers(pose->p, 3, tag, "pos") &&
                    mukca_export_read_numbers(quat, 4, tag, "quat");
    mukca_rotation_from_quaternion(pose->R, quat);
    return ok;
}

bool mukca_export_lacks_quat(const mukca_export_tag *tag)
{
    static const char *const others[] = {"euler", "axisangle", "xyaxes", "zaxis"};
    bool found = false;
    size_t length;
    for (int i = 0; i < 4; i++)
        found |= mukca_export_find_attribute(&length, tag, others[i]) != NULL;
    return found;
}

int mukca_export_find_named(mukca_export_tag *found, const char *text, const char *kind,
                            const char *name, int depth)
{
    size_t length;
    int n = 0;
    for (mukca_export_tag tag = {.at = text}; mukca_export_next_tag(&tag, kind);) {
        const char *other = mukca_export_find_attribute(&length, &tag, "name");
        if ((depth >= 0 && tag.depth != depth) || !other ||
            !mukca_export_same_name(name, other, length))
            continue;
        const bool same = length == strlen(name);
        if (same || !n++) *found = tag;
        if (same) return 1;
    }
    return n;
}

void mukca_export_put_tag(FILE *stream, const mukca_export_tag *tag,
                          const mukca_export_attribute *set, int n)
{
    const char *at = tag->at, *stop = tag->at + tag->length;
    const char *end = stop - (stop[-2] == '/' ? 2 : 1);
    size_t length;
    while (strchr(" \t\r\n", end[-1])) end--;
    while (at < end) {
        const mukca_export_attribute *next = NULL; /* the first behind `at` */
        const char *first = end, *behind = end;
        for (int k = 0; k < n; k++) {
            const char *value = mukca_export_find_attribute(&length, tag, set[k].name);
            if (!set[k].values || !value || value <= at || value >= first) continue;
            first = value;
            behind = value + length;
            next = &set[k];
        }
        fwrite(at, 1, (size_t)(first - at), stream);
        if (next) mukca_export_print(stream, "$b", next->values, next->n);
        at = behind;
    }
    for (int k = 0; k < n; k++)
        if (set[k].values && !mukca_export_find_attribute(&length, tag, set[k].name))
            mukca_export_print(stream, " $s=\"$b\"", set[k].name, set[k].values, set[k].n);
    fwrite(end, 1, (size_t)(stop - end), stream);
}

bool mukca_export_same_name(const char *name, const char *other, size_t length)
{
    char copy[256];
    snprintf(copy, sizeof copy, "%.*s", (int)length, other);
    return mukca_prefix_ends(name, copy) || mukca_prefix_ends(copy, name);
}

mukca_frame mukca_export_frame(const double xyz[3], const double rpy[3])
{
    mukca_frame frame = {.p = {xyz[0], xyz[1], xyz[2]}};
    mukca_rotation_from_rpy(frame.R, rpy);
    return frame;
}

bool mukca_export_near(const mukca_frame *a, const mukca_frame *b)
{
    return mukca_distance3(a->p, b->p) < MUKCA_EXPORT_METRES &&
           mukca_rotation_between(a->R, b->R) < MUKCA_EXPORT_RADIANS;
}
