/* Joint origins in the formats of robot makers: the `kinematics:` YAML of Universal Robots (with
 * the factory calibration of one robot), Franka and UFACTORY. */
#ifndef MUKCA_IO_KINEMATICS_H
#define MUKCA_IO_KINEMATICS_H

#include "base/text.h"
#include "mukca/chain.h"

typedef struct {
    char name[MUKCA_NAME_SIZE];
    double value[MUKCA_PARAMETERS]; /* x y z roll pitch yaw, m and rad, as of a URDF's origin */
    int line;                       /* line of its name */
} mukca_kinematics_entry;

typedef struct {
    bool root, inner; /* entries are below a key `kinematics`, numbers below `kinematic` */
    char hash[MUKCA_NAME_SIZE]; /* UR's identifier of the robot's calibration; empty: none */
    char sha256[65];            /* of the file */
    int n;
    mukca_kinematics_entry entry[MUKCA_MAX_ELEMENTS];
} mukca_kinematics;

/* Read a file.  Errors: MUKCA_INPUT (with the line), MUKCA_MEMORY. */
mukca_status mukca_kinematics_read(mukca_kinematics *kinematics, const char *path,
                                   mukca_error *error);

/* Index of the element that an entry of that name describes, -1: none.  Its joint is called NAME or
 * ends in _NAME, or its child link is called NAME_link or ends in _NAME_link. */
int mukca_kinematics_find(const mukca_chain *chain, const char *name);

/* Replace the nominal origins of `chain`; the file `path` must contain all its moving joints.
 * `note` may be NULL.  Errors: MUKCA_INPUT. */
mukca_status mukca_kinematics_apply(mukca_chain *chain, const mukca_kinematics *kinematics,
                                    const char *path, mukca_notes notes, mukca_error *error);

#endif
