/* Example of the core library in a controller: load a table once, evaluate in every cycle.
 *
 *     build/examples/example_controller offsets.tsv 0.1 0.2 0.3 -1.5 0.2 1.1 0.4
 *
 * Links libmukca_core.a and libm, nothing else.
 */
#include <stdio.h>
#include <stdlib.h>

#include "mukca/corrected.h"

int main(int argc, char **argv)
{
    static mukca_corrected arm; /* some 30 kB, caller's memory */
    mukca_error error;
    double q[MUKCA_MAX_JOINTS] = {0}, position[3], J[6 * MUKCA_MAX_JOINTS], quaternion[4];
    mukca_frame tip;
    if (argc < 2) {
        fprintf(stderr, "usage: %s OFFSETS [ANGLE...]\n", argv[0]);
        return MUKCA_USAGE;
    }
    if (mukca_corrected_load(&arm, argv[1], &error)) {
        fprintf(stderr, "%s\n", error.text);
        return (int)error.status;
    }
    const int n = arm.chain.n_joints;
    for (int j = 0; j < n && j + 2 < argc; j++) q[j] = strtod(argv[j + 2], NULL);

    /* From here on no allocation, locks or files: the part for a control loop. */
    mukca_corrected_position(position, &arm, q, NULL);
    mukca_corrected_pose(&tip, &arm, q, NULL);
    mukca_corrected_jacobian(J, NULL, &arm, q, NULL);

    mukca_rotation_to_quaternion(quaternion, tip.R);
    printf("%s of %s, %d joints, %d effects\n", arm.chain.tip, arm.chain.robot, n, arm.n_effects);
    printf("position_m %.9f %.9f %.9f\n", position[0], position[1], position[2]);
    printf("quaternion %.9f %.9f %.9f %.9f\n", quaternion[0], quaternion[1], quaternion[2],
           quaternion[3]);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < n; j++)
            printf("%s%+.6f%s", j ? " " : "", J[i * n + j], j + 1 < n ? "" : "\n");
    return MUKCA_OK;
}
