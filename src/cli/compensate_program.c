/* Correction of targets in place, in robot programs. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/note.h"
#include "cli/compensate.h"

/* Count the poses of the line (with --poses: joint targets), which remain unchanged.  Joint targets
 * also select the postures for the poses after them. */
static void read_other(compensate_job *b, mukca_program_reader *other, const char *line)
{
    mukca_program_target t;
    mukca_program_line(other, line);
    while (mukca_program_next(&t, other)) {
        b->tally.other++;
        if (!other->pose && !t.incomplete) mukca_compensator_place(&b->compensator, t.q);
    }
}

/* Note the uncorrected targets of a program.  Joint targets are corrected first: the robot then
 * reaches the poses in nearly their final postures. */
static void note_program(const compensate_job *b, const char *path)
{
    const compensate_options *o = b->call->options;
    if (b->tally.other > 0)
        mukca_note_format(cli_note, b->call, "%s: %s not corrected: %ld; %s",
                          mukca_file_shown(path), o->poses ? "joint targets" : "poses",
                          b->tally.other,
                          o->poses ? "correct these as well, without --poses"
                                   : "correct these next, in the result, with --poses");
    else if (o->poses)
        mukca_note_format(cli_note, b->call,
                          "%s: no joint target in the program determines the posture at the poses; "
                          "the first solution was used",
                          mukca_file_shown(path));
    if (b->tally.incomplete > 0)
        mukca_note_format(
            cli_note, b->call,
            "%s: targets with omitted components, after a move to a target outside the "
            "program: %ld, not corrected; write all components",
            mukca_file_shown(path), b->tally.incomplete);
}

/* Replace a target of a program by the corrected one.  A pose becomes that of the nominal model at
 * q, which takes the real arm to the intended pose; a linear move stays linear. */
static void put_in_place(const compensate_job *b, const mukca_program_reader *r,
                         const mukca_program_target *t, const double *q)
{
    mukca_frame pose;
    if (!r->pose) {
        mukca_language_replace(b->stream, r, t, q);
        return;
    }
    mukca_fk_pose(&pose, &b->compensator.nominal, q, NULL);
    mukca_language_replace_pose(b->stream, r, t, &pose);
}

/* Correct the targets of one line. */
static mukca_status correct_line(compensate_job *b, mukca_program_reader *r, const char *line,
                                 const char *path, int number)
{
    const bool in_place = b->from == b->to;
    double q[MUKCA_MAX_JOINTS] = {0};
    mukca_program_target t;
    size_t at = 0;
    mukca_program_line(r, line);
    while (mukca_program_next(&t, r)) {
        const mukca_row_reading reading = {
            .time = (double)NAN, .placement = -1, .number = (int)b->tally.rows + 1};
        if (t.incomplete) {
            b->tally.incomplete++;
            continue;
        }
        for (int j = 0; j < r->chain->n_joints && !r->pose; j++)
            if (fabs(t.q[j]) > 4 * M_PI) /* as in tables */
                return mukca_fail(&b->call->error, MUKCA_INPUT,
                                  "%s:%d: joint '%s' is %g rad, more than two turns; check --from",
                                  mukca_file_shown(path), number,
                                  mukca_chain_joint_name(r->chain, j), t.q[j]);
        if (!r->pose) memcpy(q, t.q, sizeof t.q);
        const mukca_compensation c =
            r->pose ? mukca_compensate_pose(q, &b->compensator, &t.pose, &reading)
                    : mukca_compensate_joints(q, &b->compensator, &reading);
        if (in_place) {
            fwrite(line + at, 1, t.begin - at, b->stream);
            if (r->pose && c.reach != MUKCA_REACH_OK) /* unchanged: another target would be wrong */
                fwrite(line + t.begin, 1, t.end - t.begin, b->stream);
            else
                put_in_place(b, r, &t, q);
        } else {
            compensate_put(b, q, &c);
        }
        compensate_count(b, &c, path, number);
        at = t.end;
    }
    if (in_place) fputs(line + at, b->stream);
    return MUKCA_OK;
}

mukca_status compensate_program(compensate_job *b, const char *path)
{
    cli_call *call = b->call;
    const compensate_options *o = call->options;
    mukca_program_reader reader = {.language = b->from, .chain = &b->arm->chain, .pose = o->poses},
                         other = {.language = b->from, .chain = &b->arm->chain, .pose = !o->poses};
    char *text;
    const long before = b->tally.rows;
    int number = 0;
    b->tally.other = b->tally.incomplete = 0;
    mukca_status status = mukca_file_read(&text, path, &call->error);
    if (status != MUKCA_OK) return status;
    compensate_start(b, true);
    compensate_print_header(b, false);
    for (char *line = text; status == MUKCA_OK && *line && !ferror(b->stream);) {
        char *end = line + strcspn(line, "\n");
        const bool ended = *end == '\n';
        *end = '\0';
        if (cli_interrupted()) status = MUKCA_INTERRUPTED;
        read_other(b, &other, line);
        if (status == MUKCA_OK) status = correct_line(b, &reader, line, path, ++number);
        if (ended && b->from == b->to) fputc('\n', b->stream);
        line = end + ended;
    }
    free(text);
    if (status == MUKCA_OK && b->tally.rows > before) note_program(b, path);
    if (status != MUKCA_OK || b->tally.rows > before) return status;
    return mukca_fail(&call->error, MUKCA_INPUT,
                      "%s: no %s of %d axes is a target in %s; check --from, --tip and --poses",
                      mukca_file_shown(path), o->poses ? "pose for an arm" : "list",
                      b->arm->chain.n_joints, compensate_formats[o->from]);
}
