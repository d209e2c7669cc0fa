/* Diagnosis of the error that remains after calibration of the geometry: its causes and their
 * sizes, the held-out error with and without them, and the causes that the data cannot distinguish.
 */
#ifndef MUKCA_DIAGNOSE_DIAGNOSE_H
#define MUKCA_DIAGNOSE_DIAGNOSE_H

#include <stdbool.h>

#include "base/pool.h"
#include "infer/findings.h"
#include "infer/gaussians.h"
#include "infer/sets.h"
#include "model/dataset.h"
#include "mukca/effect.h"

/* verdict, name in JSON */
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

enum { MUKCA_MAX_APPLIED = 40 }; /* effects: the causes, or all that a fleet knows of */

enum {
    MUKCA_MAX_CAUSES = MUKCA_MAX_APPLIED,
    MUKCA_MAX_TIES = 12,
    MUKCA_MAX_FAULTS = 64,
    MUKCA_MAX_TESTED = 512
};

typedef struct {
    mukca_effect_kind effect;
    int joint; /* -1: none */
    double log_bayes_factor;
    mukca_effect rival; /* with its variant */
} mukca_tie;

typedef struct {
    double before_m, after_m, shrink_percent, low_percent, high_percent; /* NaN: not measurable */
    int folds_better, folds;
} mukca_shrink;

#define MUKCA_SHRINK_NONE ((mukca_shrink){NAN, NAN, NAN, NAN, NAN, 0, 0})

typedef struct {
    mukca_effect effect;         /* kind, joint, placement, variant and coefficients, SI */
    int socket;                  /* index of a socket of the dataset, -1: none */
    int row, file;               /* 1-based data row of its file (tool_motion), 0: none */
    bool creep;                  /* tool_motion: gradual instead of a step */
    bool or_unknown;             /* a function outside the catalogue explains these data as well */
    double amplitude, low, high; /* amplitude and 95 % interval, in the effect's unit */
    double sigma[MUKCA_MAX_TERMS]; /* of the coefficients */
    double log_bayes_factor;
    double probability;
    bool suspected;     /* less probable than not, and nothing else is in its place */
    bool applied;       /* member of a finding */
    int order_range[2]; /* gear_harmonic: 95 % interval of the order */
    int n_ties;
    mukca_tie ties[MUKCA_MAX_TIES];
    mukca_shrink held_out;
    double rung_m; /* cross-validated mean error with this cause and those before it; NaN: none */
} mukca_cause;

enum { MUKCA_MAX_ALTERNATIVES = 8 };

/* A member of a finding. */
typedef struct {
    mukca_effect effect; /* kind, joint, placement, variant */
    bool listed;         /* false: outside the catalogue, at these positions */
    int family;          /* what it varies with */
    int from, to;
    double probability;
    mukca_estimate amplitude; /* in the effect's unit */
} mukca_alternative;

typedef struct {
    mukca_finding_group group;  /* positions: joints, -1 the base, n_joints the tool */
    mukca_estimate size_m;      /* rms displacement of the tip in the samples */
    double share;               /* of what all causes explain */
    double outside;             /* part of the probability outside the catalogue */
    mukca_shrink held_out;      /* with and without all of its members */
    mukca_estimate coefficient; /* sum of members that act through one quantity, */
    mukca_effect quantity;      /* that of this effect */
    int order[2];               /* 95 % interval; 0: none */
    double time_constant[2];    /* of a drift, s: least and largest probable one; HUGE_VAL: linear
                                   in time; 0: none */
    int n_alternatives;         /* by falling probability */
    mukca_alternative alternatives[MUKCA_MAX_ALTERNATIVES];
} mukca_finding;

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
    double limit; /* detection limit of the amplitude, rad or m rms at the joint; NaN: none */
    bool testable;
    const char *why; /* reason if not testable */
} mukca_tested;

typedef struct {
    int joint;
    double share; /* of the evidence for identified causes and remaining structure */
    double range_rad[2];
} mukca_where;

/* Result for use elsewhere: geometry and the causes that act on the arm, fitted together at the
 * nominal masses, with one coefficient per elastic cause. */
typedef struct {
    bool fitted;
    mukca_geometry geometry;
    mukca_frame tracker; /* pose logs: T_measured_base */
    int n_effects;
    mukca_effect effects[MUKCA_MAX_APPLIED];
    double effect_sigma[MUKCA_MAX_APPLIED][MUKCA_MAX_TERMS];
    /* [6 * n_elements] standard error and prior standard deviation of each parameter; NaN: not
     * fitted */
    double theta_sigma[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    double theta_prior[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
} mukca_applied;

/* Reading minus command of a joint, and its regression on the gravity torque. */
typedef struct {
    int rows;                /* that have both */
    double mean, rms;        /* rad or m; NaN: no such row */
    double sag, low, high;   /* rad/(N m) and its 95 % interval; NaN: torque unknown */
    double log_bayes_factor; /* of a sag against none */
} mukca_stream_difference;

/* A sag is reported from this log Bayes factor on: 150 to 1. */
#define MUKCA_SAG_EVIDENT 5.0

/* Comparison of commanded and read angles; n_joints 0: only one of them was recorded. */
typedef struct {
    int n_joints;
    mukca_stream_difference joint[MUKCA_MAX_JOINTS];
    double sigma_reading_m, sigma_command_m; /* noise of a fit of the geometry to each; NaN: none */
} mukca_streams;

/* Several pose logs: free frames that differ between logs. */
typedef struct {
    int n; /* logs; 0: no poses */
    bool base_per_log, tool_per_log;
    double log_evidence[4]; /* shared frames; a base, a tool, both per log; NaN: not compared */
} mukca_logs;

enum { MUKCA_MAX_SETS = 10 };

/* A probable set of causes, the answer to why a cause was named and not another. */
typedef struct {
    double probability;
    int n;
    struct {
        mukca_effect effect; /* kind, joint, placement, variant */
        bool unknown;        /* a function outside the catalogue, at the joint */
        int row, file;       /* outlier or moved tool: 1-based data row of its file, else 0 */
    } member[MUKCA_SET_ITEMS];
} mukca_cause_set;

typedef struct {
    mukca_verdict verdict;
    const char *why; /* reason if `untestable`, else NULL */
    bool unexplained;
    bool turned_efforts;     /* without masses: the efforts' sign is opposite, and was turned */
    double structure;        /* largest log Bayes factor of an unknown function; -HUGE_VAL: none */
    double caused_m;         /* rms displacement by all causes */
    int n_findings, n_maybe; /* the largest first */
    mukca_finding findings[MUKCA_MOST_FINDINGS], maybe[MUKCA_MOST_FINDINGS];
    int n_causes, n_suspected, n_faults, n_tested, n_where;
    mukca_cause causes[MUKCA_MAX_CAUSES];
    mukca_cause suspected[MUKCA_MAX_CAUSES]; /* less probable than not */
    mukca_data_fault faults[MUKCA_MAX_FAULTS];
    mukca_tested tested[MUKCA_MAX_TESTED];
    mukca_where where[MUKCA_MAX_JOINTS];
    int n_sets; /* the most probable sets of causes */
    mukca_cause_set sets[MUKCA_MAX_SETS];
    double axis_rms_m[3]; /* remaining error of the fitted geometry, by base axis */
    /* held-out mean errors, each placement predicted from the others, m; NaN: not measurable */
    double nominal_m, geometry_m, faults_excused_m, explained_m, noise_floor_m;
    double applied_m;      /* of the arm in the offsets table: explained_m, or a fit with traits */
    double structure_m;    /* explained_m with unknown functions included; NaN: none */
    mukca_shrink held_out; /* from faults_excused_m to explained_m */
    int folds;
    double *placement_mae_m; /* [n_placements] of applied_m, in the pool */
    /* test data (--test), m; NaN: none */
    double test_nominal_m, test_geometry_m, test_explained_m, test_applied_m;
    double *test_placement_mae_m; /* [n_test_placements] of test_applied_m, in the pool */
    /* Errors of the test data's rows, else of the held-out rows, m: nominal, and of the result;
     * NaN: faulty.  In the pool; NULL: none. */
    double *before_m, *after_m;
    int n_test_placements;
    double sigma_m, rho;
    double shared; /* share of the variance that the readings of a posture have in common */
    double efforts_correlation; /* cosine of measured and modelled holding torques; NaN: none */
    double score;               /* log posterior of the most probable causes, up to a constant */
    mukca_geometry geometry;    /* fitted with the causes */
    mukca_frame tracker;        /* pose logs: T_measured_base, of the first log */
    mukca_logs logs;
    mukca_streams streams;
    mukca_applied applied;    /* filled with options->applied */
    const mukca_chain *chain; /* fitted: with --free-tool it ends in a fixed joint; in the pool */
    double elapsed_s;
    mukca_pool pool;
} mukca_diagnosis;

/* Progress: share in [0, 1] and the present step.  Returning false interrupts. */
typedef bool mukca_progress_fn(void *context, double share, const char *doing);

/* Continuation with the regression of a diagnosis (diagnose/regression.h) before it is freed:
 * geometry, recording faults and identified causes.  Not called if nothing is testable. */
struct mukca_regression;
typedef mukca_status mukca_continue_fn(void *context, struct mukca_regression *regression,
                                       mukca_diagnosis *diagnosis, mukca_error *error);

typedef struct {
    const mukca_dataset *test;     /* test data, or NULL */
    const unsigned char *disabled; /* [MUKCA_EFFECT_COUNT] excluded effects, or NULL */
    bool free_base, free_tool;
    double mass_spread; /* relative prior sigma of each mass; 0: 0.1 */
    bool no_folds;      /* skip cross-validation */
    bool applied;       /* fill diagnosis->applied */
    int efforts;        /* without masses: their sign; 0: by the data */
    mukca_continue_fn *go_on;
    void *go_on_context;
    int threads; /* as of mukca_workers_start */
    mukca_progress_fn *progress;
    void *progress_context;
} mukca_diagnose_options;

/* Diagnose a recording.  Errors: MUKCA_MEMORY, MUKCA_INTERRUPTED, MUKCA_INPUT (no usable row).  Too
 * little data is not an error: the verdict is `untestable`. */
mukca_status mukca_diagnose(mukca_diagnosis *diagnosis, const mukca_chain *chain,
                            const mukca_dataset *data, const mukca_diagnose_options *options,
                            mukca_error *error);
void mukca_diagnosis_free(mukca_diagnosis *diagnosis);

/* By how much the log posterior of springs alone is higher if the measured efforts, the loads of an
 * arm without masses, have the opposite sign.  Errors: MUKCA_MEMORY. */
mukca_status mukca_efforts_weigh(double lead[1], struct mukca_regression *regression,
                                 const unsigned char *disabled, mukca_error *error);

/* Drop unknown functions, reduce each elastic cause to one coefficient at the nominal masses, fit
 * again, and fill `applied` with the result and its standard errors.  The regression is changed. */
void mukca_applied_fit(mukca_applied *applied, struct mukca_regression *regression);

#endif
