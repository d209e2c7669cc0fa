/* The wording of a diagnosis: recording faults, and effects that the data cannot test. */
#include <string.h>

#include "base/file.h"
#include "base/text.h"
#include "report/wording.h"

void mukca_wording_fault(char words[MUKCA_WORDING], const mukca_data_fault *f,
                         const mukca_diagnosed *r)
{
    const mukca_dataset *data = r->data;
    const double mm = 1e3 * f->size_m;
    mukca_text text = {.at = words, .size = MUKCA_WORDING};
    bool creep = false;
    const char *file = data->files ? mukca_file_name(data->files[f->file]) : "the recording";
    for (int i = 0; i < r->diagnosis->n_causes; i++) {
        const mukca_cause *c = &r->diagnosis->causes[i];
        creep |= c->creep && c->socket == f->socket && c->row == f->row;
    }
    words[0] = '\0';
    if (f->placement >= 0) mukca_text_put(&text, "%s, ", data->placements[f->placement].name);
    if (f->socket >= 0) mukca_text_put(&text, "socket %s, ", data->sockets[f->socket].label);
    mukca_text_put(&text, "row %d of %s: ", f->row, file);
    if (f->kind == MUKCA_FAULT_TOOL_MOTION)
        mukca_text_put(&text,
                       creep ? "the tool crept by %.2f mm from here on; record this socket again"
                             : "the tool moved by %.2f mm before it, or a joint slipped; record "
                               "this socket again",
                       mm);
    else if (f->kind == MUKCA_FAULT_WRONG_SOCKET)
        mukca_text_put(&text, "the ball was in another socket (%.1f mm away); correct its label",
                       mm);
    else if (f->kind == MUKCA_FAULT_OUTLIER)
        mukca_text_put(&text, "outlier of %.2f mm, not used; record it again", mm);
    else
        mukca_text_put(&text, "repeats the row before; record another posture");
}

/* Whether two tested effects have one reason; at joints, or of the whole arm. */
static bool same_reason(const mukca_tested *a, const mukca_tested *b)
{
    return !a->testable && !b->testable && (a->joint < 0) == (b->joint < 0) &&
           strcmp(a->why, b->why) == 0;
}

bool mukca_wording_untestable(char words[MUKCA_WORDING], int tested, const mukca_diagnosed *r,
                              bool caveat)
{
    const mukca_diagnosis *d = r->diagnosis;
    const mukca_tested *of = &d->tested[tested];
    const int needs = mukca_effect_table[of->effect]->needs;
    bool joint[MUKCA_MAX_JOINTS] = {false}, kind[MUKCA_EFFECT_COUNT] = {false};
    int kinds = 0, joints = 0, n = 0, first = 0;
    mukca_text text = {.at = words, .size = MUKCA_WORDING};
    while (first < tested && !same_reason(&d->tested[first], of)) first++;
    /* with readings, errors of commands are not mentioned */
    if (of->testable || first < tested ||
        (r->data->n_sockets == 0 && mukca_effect_of_sockets(of->effect)) ||
        (needs & MUKCA_NEEDS_COMMANDS && !r->data->by_command) ||
        (caveat && of->joint < 0 && (needs & MUKCA_NEEDS_MASSES)))
        return false;
    for (const mukca_tested *t = of; t < d->tested + d->n_tested; t++) {
        if (!same_reason(t, of)) continue;
        kinds += !kind[t->effect];
        kind[t->effect] = true;
        if (t->joint >= 0) joints += !joint[t->joint], joint[t->joint] = true;
    }
    words[0] = '\0';
    const bool many = kinds > 3 && joints > 0;
    if (many) mukca_text_put(&text, "%d effects", kinds);
    for (int k = 0; k < MUKCA_EFFECT_COUNT; k++)
        if (kind[k] && !many)
            mukca_text_put(&text, "%s%s", n++ ? ", " : "", mukca_effect_table[k]->title);
    for (int j = 0, at = 0; j < r->chain->n_joints; j++)
        if (joint[j])
            mukca_text_put(&text, "%s%s", at++ ? ", " : " at ",
                           mukca_chain_joint_name(r->chain, j));
    mukca_text_put(&text, " (%s)", of->why);
    return true;
}
