/* A URDF as text: checked for size, depth and xacro, its joints located by byte offsets. */
#ifndef MUKCA_IO_URDF_TEXT_H
#define MUKCA_IO_URDF_TEXT_H

#include <stdbool.h>
#include <stddef.h>

#include "mukca/chain.h"

/* One <joint> of the robot.  Offsets count bytes from the start of the text. */
typedef struct {
    char name[MUKCA_NAME_SIZE]; /* truncated to 63 characters */
    int line;
    size_t tag_end;                   /* directly after the joint's start tag */
    size_t origin_start, origin_stop; /* start tag of the origin, from `<` to after `>` */
    double xyz[3], rpy[3];            /* of the origin, as written; 0 if absent */
    bool has_origin;
    bool bad_origin; /* xyz or rpy is not three numbers */
} mukca_urdf_joint;

typedef struct {
    char *text;     /* the file's bytes, zero-terminated */
    char *elements; /* its elements and attributes only, UTF-8, as input of urdfdom */
    char sha256[65];
    bool located; /* byte offsets below are valid (false for encodings other than UTF-8) */
    int n_joints;
    mukca_urdf_joint *joints;
} mukca_urdf_text;

/* Read and check a file.  Errors: MUKCA_INPUT (also: malformed XML, with its line; nested too
 * deeply; too large; unexpanded xacro; a document type), MUKCA_MEMORY. */
mukca_status mukca_urdf_text_read(mukca_urdf_text *urdf, const char *path, mukca_error *error);
void mukca_urdf_text_free(mukca_urdf_text *urdf); /* harmless on zeroed text */

/* The joint of that name; NULL: none. */
const mukca_urdf_joint *mukca_urdf_text_joint(const mukca_urdf_text *urdf, const char *name);

#endif
