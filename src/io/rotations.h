/* Convention of measured orientations: --rotation, and its check against the arm's kinematics. */
#ifndef MUKCA_IO_ROTATIONS_H
#define MUKCA_IO_ROTATIONS_H

#include "base/text.h"
#include "io/table.h"
#include "mukca/chain.h"

/* How a log writes its orientations; zeroed: as its columns are named.  The numbers are those of
 * the columns from left to right. */
typedef struct {
    char as[8]; /* "wxyz", "xyzw", "none" (not read), "inverse" (of the measuring frame in the
                   target's), or three numbers by math/angles.h */
    char converted[8]; /* not "": another program computed the orientations from numbers that are
                          `as` by this convention */
} mukca_rotation_form;

/* Read FORM, or CONVERTED=FORM; false: there is no such form. */
bool mukca_rotation_form_read(mukca_rotation_form *form, const char *text);

/* Apply a form to the columns turn[4] of an orientation and their convention (NULL: qw qx qy qz):
 * -1 if it is not read.  Fails the table if the columns have another number. */
void mukca_rotations_map(mukca_table *table, int turn[4], const char **convention,
                         const mukca_rotation_form *form);

/* Apply it to an orientation that was read. */
void mukca_rotations_convert(double quaternion[4], const mukca_rotation_form *form);

/* Normalise a measured quaternion; false if its length deviates from 1 by more than 1 %. */
bool mukca_rotations_normalise(double quaternion[4]);

/* Replace the pose of the measuring frame in the target's frame by its inverse. */
void mukca_rotations_invert(double position[3], double quaternion[4]);

/* Samples for the check: at most MUKCA_ROTATIONS that differ in orientation. */
enum { MUKCA_ROTATIONS = 40 };
typedef struct {
    double tip[4];      /* orientation by the nominal arm */
    double raw[4];      /* numbers from left to right, rad */
    double measured[7]; /* pose as read: position, quaternion */
    double q[MUKCA_MAX_JOINTS];
} mukca_rotation_sample;
typedef struct {
    mukca_rotation_form form; /* in which the table is read */
    bool inverse;             /* its poses are inverted */
    int column, numbers;      /* its first one; numbers of an orientation, 0: a matrix */
    mukca_geometry geometry;  /* nominal */
    int n_joints, n;
    long seen;
    double reach;                 /* length of the arm, m */
    double least;                 /* rotation between two that are kept */
    char target[MUKCA_NAME_SIZE]; /* of the first */
    mukca_rotation_sample sample[MUKCA_ROTATIONS];
} mukca_rotation_samples;

/* Start a check of an arm; form, inverse, column and numbers are set by the caller. */
void mukca_rotations_start(mukca_rotation_samples *samples, const mukca_chain *chain);

/* Keep a pose as read, before its conversion and inversion (position, quaternion), if it differs
 * from those that are kept; `raw`: the orientation's numbers; `target`: its name, may be NULL. */
void mukca_rotations_keep(mukca_rotation_samples *samples, const double *q, const double pose[7],
                          const double raw[4], const char *target);

/* At the end of a table: fail it if its orientations contradict the arm that fits its positions,
 * and name the form in which they agree.  If none does, a note says so. */
void mukca_rotations_judge(mukca_table *table, const mukca_rotation_samples *samples,
                           mukca_notes notes);

#endif
