/* A calibrated model in the formats of others; each is one row of the list. */
#ifndef MUKCA_IO_EXPORT_H
#define MUKCA_IO_EXPORT_H

#include <stdio.h>

#include "io/offsets.h"

/* name, function, what it is */
#define MUKCA_EXPORT_LIST(X)                                                                \
    X(urdf, mukca_export_urdf, "the URDF itself, its origins patched, else byte-identical") \
    X(yaml, mukca_export_yaml, "xyz, rpy and quaternion of every joint's origin")           \
    X(c, mukca_export_c, "a C header of const arrays")                                      \
    X(mjcf, mukca_export_mjcf, "a MuJoCo model: origins, and springs and stops for effects")

typedef struct {
    const char *urdf_path;    /* what the chain was loaded from */
    const char *offsets_path; /* for the provenance; NULL: nominal */
    const mukca_chain *chain;
    const mukca_offsets *offsets;
    mukca_note_fn *note; /* may be NULL */
    void *context;
} mukca_export_input;

/* Write to `stream`.  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
typedef mukca_status mukca_export_fn(FILE *stream, const mukca_export_input *input,
                                     mukca_error *error);

#define MUKCA_EXPORT_DECLARE(name, function, what) mukca_export_fn function;
MUKCA_EXPORT_LIST(MUKCA_EXPORT_DECLARE)
#undef MUKCA_EXPORT_DECLARE

typedef struct {
    const char *name, *what;
    mukca_export_fn *write;
} mukca_exporter;

extern const mukca_exporter mukca_exporters[]; /* ended by a NULL name */

/* The lines of provenance, each after `prefix`. */
void mukca_export_provenance(FILE *stream, const char *prefix, const mukca_export_input *input);

/* Print a text in double quotes, escaped as C, JSON and YAML have it. */
void mukca_export_quoted(FILE *stream, const char *text);

/* Calibrated origin of an element: xyz, rpy from theta, and the quaternion, w first. */
void mukca_export_origin(double xyz[3], double rpy[3], double quaternion[4],
                         const mukca_export_input *input, int element);

#endif
