/* A calibrated model in the formats of others.  A format is one row here and one file
 * export_NAME.c that defines mukca_export_NAME. */
#ifndef MUKCA_IO_EXPORT_H
#define MUKCA_IO_EXPORT_H

#include <stdio.h>

#include "io/kinematics.h"
#include "io/offsets.h"

/* name, endings of file names, what it is */
#define MUKCA_EXPORT_LIST(X)                                                    \
    X(urdf, ".urdf", "the URDF with calibrated origins, otherwise unchanged")   \
    X(yaml, ".yaml .yml", "origins of all joints, and causes")                  \
    X(c, ".h", "C arrays of origins and axes, causes, an arm for libmukca_rt")  \
    X(mjcf, ".mjcf", "a MuJoCo model with springs and stops for causes")        \
    X(kinematics, ".kinematics", "the YAML of origins of UR, Franka, UFACTORY") \
    X(dh, ".dh", "a Denavit-Hartenberg table, standard")                        \
    X(mdh, ".mdh", "a Denavit-Hartenberg table, modified (Craig)")              \
    X(npy, ".npy", "offsets of the joints' zeros, for drake-franka-driver")

typedef struct {
    const char *urdf_path;    /* what the chain was loaded from */
    const char *offsets_path; /* for the provenance; NULL: nominal */
    const mukca_chain *chain;
    const mukca_offsets *offsets;
    const mukca_kinematics *kinematics; /* the factory file that the arm started from; or NULL */
    const double *postures; /* [n_postures][n_joints] where the arm works; NULL: joint ranges */
    int n_postures;
    const double *zeros; /* [n_joints] for the writer of a format of zeros; else ignored */
    mukca_note_fn *note; /* may be NULL */
    void *context;
} mukca_export_input;

/* Calibrated origin of an element: xyz (m), rpy (rad), and the quaternion, w first. */
typedef struct {
    double xyz[3], rpy[3], quaternion[4];
} mukca_export_origin;

/* All functions may fail with MUKCA_INPUT and MUKCA_MEMORY. */
typedef struct {
    mukca_status (*write)(FILE *stream, const mukca_export_input *input, mukca_error *error);
    /* Can the format represent this effect?  NULL: all effects. */
    bool (*holds)(const mukca_effect *effect);
    bool zeros_only;        /* the format holds one number per joint, added to its angle */
    const char *comment[2]; /* start and end of a comment; NULL: the format is XML */
} mukca_export_format;

#define MUKCA_EXPORT_DECLARE(name, endings, description) \
    extern const mukca_export_format mukca_export_##name;
MUKCA_EXPORT_LIST(MUKCA_EXPORT_DECLARE)
#undef MUKCA_EXPORT_DECLARE

typedef struct {
    const char *name, *endings;
    const mukca_export_format *format;
} mukca_exporter;

extern const mukca_exporter mukca_exporters[]; /* ended by a NULL name */

/* Index of the format for the file name `path` by its ending; 0 (URDF) where `path` is NULL or has
 * no ending, -1 where no format has it. */
int mukca_exporter_find(const char *path);

/* Write to `stream`.  For effects that the format cannot represent the origins are fitted to the
 * arm with them; what is lost is noted. */
mukca_status mukca_export_write(FILE *stream, const mukca_exporter *exporter,
                                const mukca_export_input *input, mukca_error *error);

/* An exported file compared with what would be exported now. */
typedef struct {
    int compared;    /* numbers */
    double largest;  /* difference: m, rad, or relative for numbers above 1 */
    bool agrees;     /* none above 1e-9, none missing */
    char where[160]; /* the worst place, or what is missing */
} mukca_export_difference;

/* Compare the file `path` of that format with what the input gives now.  A URDF or MuJoCo model may
 * have more elements than the chain; their joints and bodies are found by name. */
mukca_status mukca_export_check(mukca_export_difference *difference, const char *path,
                                const mukca_exporter *exporter, const mukca_export_input *input,
                                mukca_error *error);

/* ---- shared by the formats ---- */

/* Three lines of provenance, each after `prefix`. */
void mukca_export_provenance(FILE *stream, const char *prefix, const mukca_export_input *input);

/* Print a text in double quotes, escaped as C, JSON and YAML require. */
void mukca_export_quoted(FILE *stream, const char *text);

/* Print a text as an attribute's value in XML. */
void mukca_export_escaped(FILE *stream, const char *text);

/* Of a format that has no place for effects. */
bool mukca_export_holds_none(const mukca_effect *effect);

/* Print values[n], as short as they can be read back, with `separator` between them. */
void mukca_export_numbers(FILE *stream, const double *values, int n, const char *separator);

/* The calibrated origin; a parameter that the calibration did not change (within 1e-9 m or rad) is
 * the URDF's own number. */
void mukca_export_get_origin(mukca_export_origin *origin, const mukca_export_input *input,
                             int element);

/* Compare a file with what the input gives now: all numbers outside of comments and strings, in
 * order. */
void mukca_export_compare_text(mukca_export_difference *difference, const char *found,
                               const char *wanted, const char *const comment[2]);

/* Compare the elements and numbers of a chain in XML.  Returns MUKCA_OK, MUKCA_INPUT (one is not
 * well-formed) or MUKCA_MEMORY. */
mukca_status mukca_export_compare_xml(mukca_export_difference *difference, const char *found,
                                      const char *wanted);

#endif
