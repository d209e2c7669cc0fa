/* How large effects are in real arms. */
#include "effect/catalogue.h"

/* rad/(N m).  Torsional stiffness in the makers' catalogues of strain wave gears: size 32 some 15,
 * size 25 some 32, size 14 some 210, size 11 some 450 urad/(N m).  Fitted to published arms: Panda
 * joints 2 and 3 some 20, the bending before them 30 to 40, UR5 base 34, IRB 120 base 66, iiwa 7
 * joint 2 some 73.  The rare ones are small wrists and printed arms. */
const mukca_effect_sizes mukca_sizes_spring = {4,
                                               {10e-6, 30e-6, 100e-6, 300e-6, 1e-3, 3e-3, 10e-3}};

/* rad: strain wave gears below 1 arcmin (0.3 mrad), planetary ones up to 10 arcmin. */
const mukca_effect_sizes mukca_sizes_play = {4, {0.1e-3, 0.3e-3, 1e-3, 3e-3, 10e-3}};

/* rad, or rad per rad: an encoder disk of 20 mm radius off by 2 to 60 um reads 0.1 to 3 mrad off.
 */
const mukca_effect_sizes mukca_sizes_angle = {4, {0.1e-3, 0.3e-3, 1e-3, 3e-3, 10e-3}};

/* rad: the makers state a transmission accuracy of 0.5 to 2 arcmin for strain wave gears. */
const mukca_effect_sizes mukca_sizes_ripple = {4, {0.03e-3, 0.1e-3, 0.3e-3, 1e-3, 3e-3, 10e-3}};

/* rad: from a nudge to a bad homing. */
const mukca_effect_sizes mukca_sizes_zero = {5, {0.1e-3, 0.3e-3, 1e-3, 3e-3, 10e-3}};

/* m: a ball in its holder. */
const mukca_effect_sizes mukca_sizes_ball = {3, {0.05e-3, 0.2e-3, 1e-3}};

/* m: a socket, from a nudge to a wrong label. */
const mukca_effect_sizes mukca_sizes_socket = {4, {0.2e-3, 1e-3, 5e-3, 20e-3}};
