/* Joint columns that determine less than they seem to. */
#include <math.h>

#include "base/text.h"
#include "effect/catalogue.h"
#include "fit/mismatch.h"

/* Postures of the shortest run of equal angles that is no chance; a joint moves between postures by
 * more than this, rad (m of a sliding joint). */
enum { SHORTEST = 4 };
static const double moved = 5e-3;

/* Is q_b + factor q_a the same in all samples? */
static bool is_constant(const mukca_dataset *data, int b, int a, double factor)
{
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (int row = 0; row < data->n_rows && !(most - least >= MUKCA_LEAST_RANGE); row++) {
        const double *q = data->q + (size_t)row * (size_t)data->n_joints;
        const double value = q[b] + factor * q[a];
        least = fmin(least, value), most = fmax(most, value);
    }
    return !(most - least >= MUKCA_LEAST_RANGE);
}

/* Have the joints other than j moved between two successive samples? */
static bool is_other_posture(const mukca_dataset *data, int row, int j)
{
    const double *q = data->q + (size_t)row * (size_t)data->n_joints;
    for (int i = 0; i < data->n_joints; i++)
        if (i != j && fabs(q[i] - q[i - data->n_joints]) > moved) return true;
    return false;
}

/* Note a joint with the same angle, to the last digit, in one run of postures and in no two
 * successive ones elsewhere: programs that hold a joint on purpose do it more often. */
static void note_run(mukca_notes notes, const mukca_chain *chain, const mukca_dataset *data, int j)
{
    int postures = 1, equal = 0, length = 1, most = 0, first = 0, from = 0, to = 0;
    for (int row = 1; row < data->n_rows; row++) {
        const double *q = data->q + (size_t)row * (size_t)data->n_joints + j;
        const bool same = q[0] == q[-data->n_joints] && data->file[row] == data->file[row - 1];
        const bool other = is_other_posture(data, row, j);
        postures += other;
        equal += same && other;
        length = same ? length + other : 1;
        if (!same) first = row;
        if (length >= most) most = length, from = first, to = row;
    }
    if (most >= SHORTEST && equal == most - 1 && 2 * most < postures)
        mukca_note_format(notes,
                          "%s reads %.6g in rows %d to %d%s%s while other joints move, and never "
                          "the same in successive postures elsewhere; if it moved, check cable, "
                          "encoder and drive, and remove these rows",
                          mukca_chain_joint_name(chain, j),
                          data->q[(size_t)to * (size_t)data->n_joints + (size_t)j], data->row[from],
                          data->row[to], data->n_files > 1 ? " of " : "",
                          data->n_files > 1 ? data->files[data->file[to]] : "");
}

void mukca_columns_note(mukca_notes notes, const mukca_chain *chain, const mukca_dataset *data)
{
    char still[160] = "";
    mukca_text list = MUKCA_TEXT(still);
    int n_still = 0;
    for (int b = 0; b < data->n_joints; b++) {
        if (is_constant(data, b, b, 0)) {
            mukca_text_put(&list, "%s%s", n_still++ ? ", " : "", mukca_chain_joint_name(chain, b));
            continue;
        }
        note_run(notes, chain, data, b);
        for (int a = 0; a < b; a++)
            for (int sign = -1; sign <= 1; sign += 2)
                if (is_constant(data, b, a, sign) && !is_constant(data, a, a, 0))
                    mukca_note_format(notes,
                                      "the columns of %s and %s %s in all samples: a wrong column, "
                                      "or a joint that follows the other; their offsets cannot be "
                                      "told apart",
                                      mukca_chain_joint_name(chain, a),
                                      mukca_chain_joint_name(chain, b),
                                      sign < 0 ? "differ by a constant" : "have a constant sum");
    }
    if (n_still && n_still < data->n_joints)
        mukca_note_format(notes,
                          "did not move in any sample: %s; if it was moved, its column or encoder "
                          "is stuck, and no result is valid",
                          still);
}
