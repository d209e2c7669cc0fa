/* Static gravity load of the joints. */
#ifndef MUKCA_GRAVITY_H
#define MUKCA_GRAVITY_H

#include "mukca/chain.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Standard gravity, m/s^2 (General Conference on Weights and Measures, 1901). */
#define MUKCA_GRAVITY 9.80665

/* Gravity load of the joints in one configuration, N m. */
typedef struct {
    double moment[MUKCA_MAX_JOINTS]
                 [3]; /* about each joint's origin, in its frame before its rotation */
    double torque[MUKCA_MAX_JOINTS]; /* component about the axis; prismatic: force along it, N */
    double base[3];                  /* the same about the base origin, in the base frame */
} mukca_gravity_load;

/* Masses of the bodies that move with each element, and their first moments (child frame). */
typedef struct {
    double kg[MUKCA_MAX_ELEMENTS], first[MUKCA_MAX_ELEMENTS][3]; /* kg m */
} mukca_masses;

/* `mass_scale` and `payload_kg` as below. */
void mukca_chain_masses(mukca_masses *masses, const mukca_chain *chain, const double *mass_scale,
                        double payload_kg);

/* Static load at q[n_joints] in the displaced posture; moments in the joints' displaced frames.
 * `displacement` may be NULL. */
void mukca_chain_load(mukca_gravity_load *load, const mukca_chain *chain,
                      const mukca_geometry *geometry, const double *q,
                      const mukca_displacement *displacement, const mukca_masses *masses);

/* Static load of the masses at q[n_joints].  `mass_scale` (n_masses factors) may be NULL;
 * `payload_kg` sits at the tip.  Linear in elements and masses. */
void mukca_chain_moments(mukca_gravity_load *load, const mukca_chain *chain,
                         const mukca_geometry *geometry, const double *q, const double *mass_scale,
                         double payload_kg);

#ifdef __cplusplus
}
#endif
#endif
