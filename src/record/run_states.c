/* Runs from joint states. */
#include "record/joint_lines.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/text.h"
#include "io/export.h"
#include "lcm/link.h"

typedef struct {
    const mukca_chain *chain;
    const mukca_run_options *options;
    mukca_run_rows rows;
    const char *path;
    mukca_status status; /* of the first failure */
    mukca_error *error;
    int64_t first;      /* us, of the first state */
    bool efforts;       /* some state has what efforts are made of, */
    bool current;       /* motor currents */
    int states, others; /* of the arm; without all of its joints */
    char channel[MUKCA_LCM_CHANNEL_SIZE];
} reader;

/* Index of a joint of the arm among the names, else by order; -1: none. */
static int find(const mukca_lcm_joints *s, const mukca_chain *chain, int joint)
{
    const char *name = mukca_chain_joint_name(chain, joint);
    if (!s->has[MUKCA_LCM_ROLE_NAME]) return s->n == chain->n_joints ? joint : -1;
    for (int k = 0; k < s->n; k++)
        if (strcmp(s->name[k], name) == 0) return k;
    for (int k = 0; k < s->n; k++)
        if (mukca_export_same_name(name, s->name[k], strlen(s->name[k]))) return k;
    return -1;
}

/* Add a joint state, time in us; false: it has not all joints of the arm. */
static bool add(reader *r, const mukca_lcm_joints *s, int64_t time)
{
    const mukca_run_options *o = r->options;
    const int n = r->chain->n_joints;
    const bool commands = !s->has[MUKCA_LCM_ROLE_EFFORT] && s->has[MUKCA_LCM_ROLE_COMMAND] &&
                          isfinite(o->stiffness[0]);
    double row[1 + 3 * MUKCA_MAX_JOINTS];
    if (!r->states) r->first = time;
    row[0] = 1e-6 * (double)(time - r->first);
    for (int j = 0; j < n; j++) {
        const int k = find(s, r->chain, j);
        if (k < 0) return false;
        const double q = s->value[MUKCA_LCM_ROLE_POSITION][k];
        row[1 + j] = q;
        row[1 + n + j] =
            s->has[MUKCA_LCM_ROLE_VELOCITY] ? s->value[MUKCA_LCM_ROLE_VELOCITY][k] : (double)NAN;
        row[1 + 2 * n + j] = commands ? o->stiffness[j] * (s->value[MUKCA_LCM_ROLE_COMMAND][k] - q)
                             : s->has[MUKCA_LCM_ROLE_EFFORT] ? s->value[MUKCA_LCM_ROLE_EFFORT][k] *
                                                                   (o->current ? o->gain[j] : 1)
                                                             : (double)NAN;
    }
    r->efforts |= commands || s->has[MUKCA_LCM_ROLE_EFFORT];
    r->current |= s->has[MUKCA_LCM_ROLE_EFFORT] && o->current;
    r->states++;
    const double fell = mukca_run_rows_add(&r->rows, row, n);
    if (fell > 0 && r->status == MUKCA_OK)
        r->status =
            mukca_fail(r->error, MUKCA_INPUT,
                       "%s: the time of the joint states falls by %.3g s; record each run, and "
                       "each arm, to a file of its own",
                       mukca_file_shown(r->path), fell);
    return true;
}

static void read_log(reader *r)
{
    mukca_lcm_log log = {0};
    mukca_lcm_packet event;
    mukca_lcm_types *types = calloc(1, sizeof *types);
    mukca_error error;
    if (!types) {
        r->status = mukca_fail(r->error, MUKCA_MEMORY, "out of memory");
        return;
    }
    r->status = mukca_lcm_types_init(types, r->error);
    if (r->status == MUKCA_OK) r->status = mukca_lcm_log_open(&log, r->path, r->error);
    while (r->status == MUKCA_OK && mukca_lcm_log_read(&event, &log)) {
        mukca_lcm_joints state;
        const int type = mukca_lcm_types_find(types, event.data, event.size);
        if (!mukca_lcm_type_has_joints(types, type)) continue;
        if (r->channel[0] && strcmp(event.channel, r->channel) != 0) continue;
        if (mukca_lcm_decode_joints(&state, types, type, event.data, event.size, &error) ||
            !add(r, &state, state.time ? state.time : event.time)) {
            r->others++;
            continue;
        }
        if (!r->channel[0]) snprintf(r->channel, sizeof r->channel, "%s", event.channel);
    }
    mukca_lcm_log_close(&log);
    free(types);
}

static void read_lines(reader *r, int file)
{
    mukca_joint_lines *lines = malloc(sizeof *lines);
    if (!lines) {
        r->status = mukca_fail(r->error, MUKCA_MEMORY, "out of memory");
        return;
    }
    mukca_joint_lines_open(lines, file);
    while (r->status == MUKCA_OK && !lines->ended) {
        mukca_joint_lines_fill(lines);
        for (const char *line; r->status == MUKCA_OK && (line = mukca_joint_lines_peek(lines));
             mukca_joint_lines_take(lines)) {
            mukca_lcm_joints state;
            mukca_error error;
            const mukca_line_kind kind = mukca_joint_lines_parse(&state, lines, line, &error);
            const bool cut_off = lines->start + strlen(line) >= lines->used;
            if (kind == MUKCA_LINE_FAULT && cut_off)
                mukca_note_format(r->options->notes, "%s: the last line is cut off",
                                  mukca_file_shown(r->path));
            else if (kind == MUKCA_LINE_FAULT)
                r->status = mukca_fail(r->error, MUKCA_INPUT, "%s:%d: %s",
                                       mukca_file_shown(r->path), lines->number + 1, error.text);
            else if (kind == MUKCA_LINE_JOINTS && (!lines->timed || !add(r, &state, state.time)))
                r->others++;
        }
    }
    free(lines);
}

/* Whether a text begins with a message: whole s and ns, as `ros2 topic echo --csv` has them, or
 * JSON.  A table of a run begins with names. */
static bool is_message(const char *text)
{
    char comma;
    return *text == '{' || (sscanf(text, "%*d,%*d%c", &comma) == 1 && comma == ',');
}

mukca_status mukca_run_load(mukca_run *run, mukca_pool *pool, const char *path,
                            const mukca_chain *chain, const mukca_run_options *o,
                            mukca_error *error)
{
    char head[256] = "";
    reader r = {.chain = chain, .options = o, .path = path, .error = error};
    const int file = strcmp(path, "-") == 0 ? -1 : open(path, O_RDONLY | O_CLOEXEC);
    const ssize_t n = file < 0 ? 0 : pread(file, head, sizeof head - 1, 0);
    const bool log = n >= 4 && memcmp(head, mukca_lcm_log_sync, 4) == 0;
    const bool lines = !log && n > 0 && is_message(head);
    if (log) read_log(&r);
    if (lines) read_lines(&r, file);
    if (file >= 0) close(file);
    if (!log && !lines) return mukca_run_read(run, pool, path, chain, o, error);
    snprintf(run->name, sizeof run->name, "%.60s", mukca_file_name(path));
    run->current = r.current;
    if (r.status == MUKCA_OK && !r.states)
        r.status =
            mukca_fail(error, MUKCA_INPUT, "%s: no joint state has all %d joints of the arm%s",
                       mukca_file_shown(path), chain->n_joints,
                       r.others ? "; check the names of its joints" : "");
    if (r.status == MUKCA_OK && !r.efforts)
        r.status = mukca_fail(error, MUKCA_INPUT,
                              "%s: the joint states have no efforts; record torques, or give --kp "
                              "for those with commands",
                              mukca_file_shown(path));
    if (r.status == MUKCA_OK) {
        r.status = mukca_run_rows_take(run, pool, &r.rows, chain, o);
        if (r.status != MUKCA_OK) mukca_fail(error, r.status, "out of memory for %s", run->name);
    }
    if (r.status == MUKCA_OK && r.others)
        mukca_note_format(o->notes, "%s: %d joint states of others left out", run->name, r.others);
    free(r.rows.sample);
    return r.status;
}
