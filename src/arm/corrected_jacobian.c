/* Jacobian of the corrected arm: the equilibrium under load moves with the joints' angles. */
#include "arm/corrected_jacobian.h"

#include <string.h>

/* A value in the lane of joint `j`, in registers: parts of a vector in memory make its reader wait.
 */
#if MUKCA_LANES > 1
#define IN_LANE(l, value)                                                            \
    ((lanes){(l) == 0 ? (value) : 0, (l) == 1 ? (value) : 0, (l) == 2 ? (value) : 0, \
             (l) == 3 ? (value) : 0})
#else
#define IN_LANE(l, value) ((l) == 0 ? (value) : 0)
#endif

/* Rates without load as joints `first`, `first` + 1, ... turn. */
PART void set_unloaded(mukca_posture_rates *r, const mukca_equilibrium *e,
                       const mukca_effect_slopes *slopes, int first)
{
    for (int i = 0; i < 3; i++) r->base[i] = (lanes){0};
    for (int j = 0; j < e->n_joints; j++) {
        r->angle[j] = LOAD_LANES(&slopes->angle[j][first]);
        for (int i = 0; i < 3 && e->joint[j].tilts; i++)
            r->rotation[j][i] = IN_LANE(j - first, slopes->rotation[j][i]);
    }
}

/* Columns `first`, `first` + 1, ... of the Jacobian. */
PART void fill_columns(double *J, const mukca_posture_rates *r, const mukca_equilibrium *e,
                       int first)
{
    const int n = e->n_joints;
    lanes v[3] = {0}, w[3];
    for (int i = 0; i < 3; i++) w[i] = r->base[i];
    for (int j = 0; j < n; j++) {
        const mukca_joint_posture *at = &e->joint[j];
        lanes turn[3];
        for (int i = 0; i < 3; i++) {
            const lanes own = r->angle[j] * at->axis[i];
            turn[i] = at->tilts ? r->rotation[j][i] : (lanes){0};
            *(at->slides ? &v[i] : &turn[i]) += own;
            w[i] += turn[i];
        }
        for (int i = 0; i < 3; i++) {
            const int a = (i + 1) % 3, b = (i + 2) % 3;
            v[i] += COLUMN(&at->frame, 3, a) * turn[b] - COLUMN(&at->frame, 3, b) * turn[a];
        }
    }
    for (int i = 0; i < 3; i++) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        v[i] -= e->tip.p[a] * w[b] - e->tip.p[b] * w[a];
    }
    for (int i = 0; i < 3; i++)
        for (int l = 0; l < MUKCA_LANES && first + l < n; l++) {
            J[i * n + first + l] = ((const double *)&v[i])[l];
            J[(3 + i) * n + first + l] = ((const double *)&w[i])[l];
        }
}

MUKCA_CLONES void mukca_corrected_differentiate(double *J, mukca_equilibrium *e,
                                                mukca_effect_slopes *slopes)
{
    mukca_posture_rates r;
    mukca_equilibrium_rates(e, slopes);
    for (int first = 0; first < e->n_joints; first += MUKCA_LANES) {
        set_unloaded(&r, e, slopes, first);
        mukca_equilibrium_settle(&r, e, 2e-11);
        fill_columns(J, &r, e, first);
    }
}
