/* Export of a calibrated model to the formats of other programs.  A format is one row here and one
 * file export_NAME.c that defines mukca_export_NAME. */
#ifndef MUKCA_IO_EXPORT_H
#define MUKCA_IO_EXPORT_H

#include <stdio.h>

#include "io/kinematics.h"
#include "io/offsets.h"

/* name, endings of file names, description */
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
    const char *urdf_path;    /* source of the chain */
    const char *offsets_path; /* source of the offsets, for the provenance; NULL: nominal */
    const mukca_chain *chain;
    const mukca_offsets *offsets;
    const mukca_kinematics *kinematics; /* factory calibration that the chain includes; or NULL */
    const double *postures; /* [n_postures][n_joints] of the arm's task; NULL: joint ranges */
    int n_postures;
    const double *zeros; /* [n_joints] refitted zero offsets for a format with zeros_only */
    const char *into;    /* the URDF or MuJoCo model that is patched */
    const char *motion;  /* table of mukca motion, for mukca_export_motion */
    bool other_arm;      /* that may be of another URDF */
    mukca_notes notes;
    mukca_error *error;
} mukca_export_input;

/* Calibrated origin of an element: xyz (m), rpy (rad), and the quaternion, w first. */
typedef struct {
    union {
        struct {
            double xyz[3], rpy[3];
        };
        double theta[MUKCA_PARAMETERS]; /* the same */
    };
    double quaternion[4];
    bool moved; /* differs from the URDF's */
} mukca_export_origin;

/* All functions may fail with MUKCA_INPUT or MUKCA_MEMORY. */
typedef struct {
    mukca_status (*write)(FILE *stream, const mukca_export_input *input);
    bool holds_all;                            /* the format can represent every effect, */
    bool (*holds)(const mukca_effect *effect); /* or these; NULL: none */
    bool zeros_only;        /* the format has one number per joint, added to its angle */
    const char *comment[2]; /* start and end of a comment; NULL: of XML */
} mukca_export_format;

#define MUKCA_EXPORT_DECLARE(name, endings, description) \
    extern const mukca_export_format mukca_export_##name;
MUKCA_EXPORT_LIST(MUKCA_EXPORT_DECLARE)
#undef MUKCA_EXPORT_DECLARE
/* A user's URDF or MuJoCo model with the arm's poses replaced; not in the list. */
extern const mukca_export_format mukca_export_into;
/* The same with friction, armature and masses of `motion`. */
extern const mukca_export_format mukca_export_motion;

typedef struct {
    const char *name, *endings;
    const mukca_export_format *format;
} mukca_exporter;

extern const mukca_exporter mukca_exporters[]; /* ended by a NULL name */

/* Index of the format for the file name `path` by its ending; 0 (URDF) if `path` is NULL or has no
 * ending; -1: no such format. */
int mukca_exporter_find(const char *path);

/* Write to `stream`.  Effects that the format cannot represent are approximated by refitted
 * origins; the remaining error is noted. */
mukca_status mukca_export_write(FILE *stream, const mukca_exporter *exporter,
                                const mukca_export_input *input);

/* ---- shared by the formats ---- */

/* Print three lines of provenance, each preceded by `prefix`. */
void mukca_export_provenance(FILE *stream, const char *prefix, const mukca_export_input *input);

/* A start tag of XML; zeroed but for `at`, the text: before the first. */
typedef struct {
    const char *at;
    size_t length;   /* with < and > */
    int depth, open; /* 0: of the root; elements that are open behind the tag */
} mukca_export_tag;

/* Advance to the next start tag `name` (NULL: any), or false; comments and the like have none. */
bool mukca_export_next_tag(mukca_export_tag *tag, const char *name);
bool mukca_export_is_tag(const mukca_export_tag *tag, const char *name);

/* Find the first element `kind` directly below a tag. */
bool mukca_export_find_below(mukca_export_tag *tag, const mukca_export_tag *of, const char *kind);

/* The value of an attribute in a tag, without its quotes, and its length; NULL: absent. */
const char *mukca_export_find_attribute(size_t *length, const mukca_export_tag *tag,
                                        const char *name);

/* Print a tag with numbers as the values of attributes set[n], where they are or at its end.  NULL:
 * unchanged. */
typedef struct {
    const char *name;
    const double *values;
    int n;
} mukca_export_attribute;
void mukca_export_put_tag(FILE *stream, const mukca_export_tag *tag,
                          const mukca_export_attribute *set, int n);

/* Print `format`, in which a directive stands for each further argument: $i an int; $s a text, $q
 * in double quotes, escaped as C, JSON and YAML require, $x as the value of an attribute in XML, $p
 * without characters that end a comment of C or XML; $n a number, and $c, $b numbers (const double
 * *, int) with commas or blanks between, each with the fewest digits that read back exactly,
 * infinite ones as C's HUGE_VAL; $l integers (const signed char *, int) with
 * commas. */
void mukca_export_print(FILE *stream, const char *format, ...);

/* Whether two names are equal, or one has a prefix: "panda_link1" and "link1". */
bool mukca_export_same_name(const char *name, const char *other, size_t length);

/* Read numbers of an attribute; without it they stay.  False: unreadable. */
bool mukca_export_read_numbers(double *values, int n, const mukca_export_tag *tag,
                               const char *name);

/* Read the pose of a MuJoCo element, from pos and quat if it has them; false: unreadable. */
bool mukca_export_read_pose(mukca_frame *pose, const mukca_export_tag *tag);

/* Whether a MuJoCo element has its orientation in other numbers than quat. */
bool mukca_export_lacks_quat(const mukca_export_tag *tag);

/* Find the tag `kind` with a name, or else with a prefix of it, at a depth (-1: any); returns their
 * number. */
int mukca_export_find_named(mukca_export_tag *found, const char *text, const char *kind,
                            const char *name, int depth);

/* Get the frame of the body of an element in a MuJoCo model, in that of the element. */
mukca_status mukca_export_body_frame(mukca_frame *body, const char *text, int element,
                                     const mukca_export_input *input);

/* Names of a link's ten inertial parameters in tables, as in inverse_dynamics.h. */
extern const char *const mukca_export_inertial[10];

mukca_frame mukca_export_frame(const double xyz[3], const double rpy[3]);

/* Whether two poses are those of one arm, up to rounded numbers and other versions of the arm. */
#define MUKCA_EXPORT_METRES 2e-3
#define MUKCA_EXPORT_RADIANS 5e-3
bool mukca_export_near(const mukca_frame *a, const mukca_frame *b);

/* Get the calibrated origin; parameters changed by less than 1e-9 m or rad are exactly those of the
 * URDF. */
void mukca_export_get_origin(mukca_export_origin *origin, const mukca_export_input *input,
                             int element);

#endif
