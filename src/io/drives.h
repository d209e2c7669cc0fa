/* Friction and armature of an arm's joints from its URDF or MuJoCo model. */
#ifndef MUKCA_IO_DRIVES_H
#define MUKCA_IO_DRIVES_H

#include "motion/motion.h"
#include "mukca/status.h"

/* Parameters of a drive: effect of mukca motion; attribute of a MuJoCo joint, and of the <dynamics>
 * of a URDF (NULL: none).  In the order of mukca_drives. */
enum { MUKCA_DRIVE_VALUES = 3 };
typedef struct {
    const char *effect, *mjcf, *urdf;
} mukca_drive_value;
extern const mukca_drive_value mukca_drive_values[MUKCA_DRIVE_VALUES];

/* Read friction, damping and armature of the joints: of a URDF the <dynamics> of the robot's
 * joints, of a MuJoCo model the attributes of joints and of their default classes.  Joints without
 * them have none.  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_drives_read(mukca_drives *drives, const char *path, const mukca_chain *chain,
                               mukca_error *error);

#endif
