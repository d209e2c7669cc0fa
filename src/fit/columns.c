/* Joint columns that determine less than they seem to. */
#include "fit/columns.h"

#include <math.h>

#include "base/text.h"
#include "effect/catalogue.h"

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

void mukca_columns_note(mukca_note_fn *note, void *context, const mukca_chain *chain,
                        const mukca_dataset *data)
{
    char still[160] = "";
    mukca_text list = MUKCA_TEXT(still);
    int n_still = 0;
    for (int b = 0; b < data->n_joints; b++) {
        if (is_constant(data, b, b, 0)) {
            mukca_text_put(&list, "%s%s", n_still++ ? ", " : "", mukca_chain_joint_name(chain, b));
            continue;
        }
        for (int a = 0; a < b; a++)
            for (int sign = -1; sign <= 1; sign += 2)
                if (is_constant(data, b, a, sign) && !is_constant(data, a, a, 0))
                    mukca_note_format(note, context,
                                      "the columns of %s and %s %s in all samples: a wrong column, "
                                      "or a joint that follows the other; their offsets cannot be "
                                      "told apart",
                                      mukca_chain_joint_name(chain, a),
                                      mukca_chain_joint_name(chain, b),
                                      sign < 0 ? "differ by a constant" : "have a constant sum");
    }
    if (n_still && n_still < data->n_joints)
        mukca_note_format(note, context,
                          "did not move in any sample: %s; if it was moved, its column or encoder "
                          "is stuck, and no result is valid",
                          still);
}
