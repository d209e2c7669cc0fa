/* Diagnosis of the error that a calibrated geometry leaves: which effects cause it and how much,
 * the held-out error with and without them, and what the data cannot distinguish. */
#ifndef MUKCA_DIAGNOSE_DIAGNOSE_H
#define MUKCA_DIAGNOSE_DIAGNOSE_H

#include <stdbool.h>

#include "base/pool.h"
#include "mukca/dataset.h"
#include "mukca/effect.h"

/* verdict, name in the JSON */
#define MUKCA_VERDICT_LIST(X) \
    X(NONE, "none")           \
    X(NAMED, "named")         \
    X(TIED, "tied")           \
    X(UNKNOWN, "unknown")     \
    X(UNTESTABLE, "untestable")

typedef enum {
#define MUKCA_VERDICT_ENUM(name, text) MUKCA_VERDICT_##name,
    MUKCA_VERDICT_LIST(MUKCA_VERDICT_ENUM)
#undef MUKCA_VERDICT_ENUM
} mukca_verdict;

extern const char *const mukca_verdict_name[];

#define MUKCA_FAULT_LIST(X)         \
    X(TOOL_MOTION, "tool_motion")   \
    X(WRONG_SOCKET, "wrong_socket") \
    X(OUTLIER, "outlier")           \
    X(DUPLICATE, "duplicate")

typedef enum {
#define MUKCA_FAULT_ENUM(name, text) MUKCA_FAULT_##name,
    MUKCA_FAULT_LIST(MUKCA_FAULT_ENUM)
#undef MUKCA_FAULT_ENUM
} mukca_fault_kind;

extern const char *const mukca_fault_name[];

enum { MUKCA_MAX_APPLIED = 40 }; /* effects: the causes, or all that a fleet knows */

enum { MUKCA_MAX_CAUSES = 16, MUKCA_MAX_TIES = 12, MUKCA_MAX_FAULTS = 64, MUKCA_MAX_TESTED = 512 };

typedef struct {
    mukca_effect_kind effect;
    int joint; /* -1: none */
    double log_bayes_factor;
    double correlation; /* canonical, after geometry is projected out; NaN: not computed */
    mukca_effect rival; /* with its variant, about as large as the cause */
} mukca_tie;

typedef struct {
    double before_m, after_m, shrink_percent, low_percent, high_percent; /* NaN: not measurable */
    int folds_better, folds;
} mukca_shrink;

#define MUKCA_SHRINK_NONE                  \
    ((mukca_shrink){.before_m = NAN,       \
                    .after_m = NAN,        \
                    .shrink_percent = NAN, \
                    .low_percent = NAN,    \
                    .high_percent = NAN})

typedef struct {
    mukca_effect effect; /* kind, joint, placement, variant and coefficients, SI */
    int socket;          /* index into the dataset's sockets, -1: none */
    int row, file;       /* 1-based data row of the file (tool_motion), 0: none */
    bool creep;          /* tool_motion: crept rather than moved once */
    bool or_unknown;     /* a function that no effect makes would do as well, by these rows */
    double amplitude, low, high;   /* size and 95 % interval in the effect's unit */
    double sigma[MUKCA_MAX_TERMS]; /* of the coefficients */
    double log_bayes_factor;
    double probability;
    int n_ties;
    mukca_tie ties[MUKCA_MAX_TIES];
    mukca_shrink held_out;
} mukca_cause;

typedef struct {
    mukca_fault_kind kind;
    int placement, socket; /* indices, -1: none (a pose log) */
    int row, file;         /* 1-based data row of its file */
    int data_row;          /* 0-based row of the dataset */
    double size_m;
} mukca_data_fault;

typedef struct {
    mukca_effect_kind effect;
    int joint; /* -1: none */
    double log_bayes_factor, log_odds;
    double limit; /* amplitude (rad or m rms at the joint) that these data would show, NaN: none */
    bool testable;
    const char *why; /* where not testable */
} mukca_tested;

typedef struct {
    int joint;
    double share; /* of the evidence for what remains or was found */
    double range_rad[2];
} mukca_where;

/* What can be applied elsewhere: geometry and the causes that act on the arm, fitted together with
 * the masses as they are named, one coefficient for each elastic cause. */
typedef struct {
    bool fitted;
    mukca_geometry geometry;
    mukca_frame tracker; /* pose logs: T_measured_base */
    int n_effects;
    mukca_effect effects[MUKCA_MAX_APPLIED];
    double effect_sigma[MUKCA_MAX_APPLIED][MUKCA_MAX_TERMS];
    /* [6 * n_elements] standard error of each parameter, and that of what was believed before the
     * rows; NaN: not fitted */
    double theta_sigma[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    double theta_prior[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
} mukca_applied;

enum { MUKCA_MAX_CONFOUNDED = 12 };

/* What is confounded with what: the largest canonical correlation of each pair of causes and close
 * candidates, after geometry is projected out; 1: indistinguishable, NaN: not defined. */
typedef struct {
    int n;
    mukca_effect effects[MUKCA_MAX_CONFOUNDED]; /* without coefficients */
    bool cause[MUKCA_MAX_CONFOUNDED];           /* identified; else a candidate */
    double correlation[MUKCA_MAX_CONFOUNDED][MUKCA_MAX_CONFOUNDED];
} mukca_confounding;

/* Reading minus command of a joint, and how it goes with gravity's torque. */
typedef struct {
    int rows;                /* in which both were recorded */
    double mean, rms;        /* rad or m; NaN: never */
    double sag, low, high;   /* rad/(N m) and its 95 % interval; NaN: no torque known */
    double log_bayes_factor; /* of a sag against none */
} mukca_stream;

/* From this log Bayes factor on a sag is reported: 150 to 1. */
#define MUKCA_SAG_EVIDENT 5.0

/* Both streams of angles; n_joints 0: one was recorded. */
typedef struct {
    int n_joints;
    mukca_stream joint[MUKCA_MAX_JOINTS];
    double sigma_reading_m, sigma_command_m; /* noise of a fit of the geometry to each; NaN: none */
} mukca_streams;

/* Several pose logs: which of their free frames differ from log to log. */
typedef struct {
    int n; /* logs; 0: no poses */
    bool base_per_log, tool_per_log;
    double log_evidence[4]; /* shared frames, a base, a tool, both per log; NaN: not compared */
} mukca_logs;

typedef struct {
    mukca_verdict verdict;
    const char *why; /* it is `untestable`, else NULL */
    bool unexplained;
    int n_causes, n_suspected, n_faults, n_tested, n_where;
    mukca_cause causes[MUKCA_MAX_CAUSES];
    mukca_cause
        suspected[MUKCA_MAX_CAUSES]; /* leaving them out does not raise the held-out error */
    mukca_data_fault faults[MUKCA_MAX_FAULTS];
    mukca_tested tested[MUKCA_MAX_TESTED];
    mukca_where where[MUKCA_MAX_JOINTS];
    double axis_rms_m[3]; /* what geometry leaves, by base axis */
    /* held-out mean errors, leave one placement out, m; NaN: not measurable */
    double nominal_m, geometry_m, faults_excused_m, explained_m, noise_floor_m;
    double structure_m; /* as explained_m, but with the functions that nobody can name; NaN: none */
    double surprise;    /* held-out samples' rms misfit with all causes, in units of what noise
                           and the other rows' ignorance allow; NaN: not measurable */
    double surprise_sigmas;      /* how far its square is above 1, in standard deviations */
    mukca_shrink held_out;       /* from faults_excused_m to explained_m */
    double noise_shrink_percent; /* what the best of the catalogue gains on pure noise */
    int folds;
    double *placement_mae_m; /* [n_placements] explained, in the pool */
    /* held-out data (--test), m; NaN without */
    double test_nominal_m, test_geometry_m, test_explained_m;
    double *test_placement_mae_m; /* [test placements] explained */
    int n_test_placements;
    double sigma_m, rho;
    double score;               /* log posterior of all that was accepted, up to a constant */
    double gravity[3];          /* one that explains the data far better, m/s^2; 0: none does */
    double efforts_correlation; /* cosine of measured and modelled holding torques; NaN without */
    mukca_geometry geometry;    /* fitted with the causes */
    mukca_frame tracker;        /* pose logs: T_measured_base, of the first log */
    mukca_logs logs;
    mukca_streams streams;
    mukca_applied applied;         /* with options->applied */
    mukca_confounding confounding; /* with options->confounding */
    double elapsed_s;
    mukca_pool pool;
} mukca_diagnosis;

/* What people may watch while it runs: share in [0, 1] and what it is doing.  Returning false
 * interrupts. */
typedef bool mukca_progress_fn(void *context, double share, const char *doing);

/* What may go on with the regression of a diagnosis (diagnose/regression.h) before it is freed:
 * geometry, recording faults and the causes that were found.  Not called where nothing can be
 * tested. */
struct mukca_regression;
typedef mukca_status mukca_continue_fn(void *context, struct mukca_regression *regression,
                                       mukca_diagnosis *diagnosis, mukca_error *error);

typedef struct {
    const mukca_dataset *test;     /* held-out data, or NULL */
    const unsigned char *disabled; /* [MUKCA_EFFECT_COUNT] effects left out, or NULL */
    bool free_base, free_tool;
    double mass_spread; /* relative sigma of each mass; 0: 0.1 */
    bool no_folds;      /* skip the held-out measurement */
    bool applied;       /* fit what can be applied elsewhere, too */
    bool confounding;   /* measure what is confounded with what */
    mukca_continue_fn *go_on;
    void *go_on_context;
    mukca_progress_fn *progress;
    void *progress_context;
} mukca_diagnose_options;

/* Diagnose a recording.  Errors: MUKCA_MEMORY, MUKCA_INTERRUPTED, MUKCA_INPUT (no usable row).
 * Too little data is no error but the verdict `untestable`. */
mukca_status mukca_diagnose(mukca_diagnosis *diagnosis, const mukca_chain *chain,
                            const mukca_dataset *data, const mukca_diagnose_options *options,
                            mukca_error *error);
void mukca_diagnosis_free(mukca_diagnosis *diagnosis);

#endif
