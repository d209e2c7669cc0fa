/* Offsets tables: the results of a calibration and a diagnosis, with their provenance. */
#ifndef MUKCA_ARM_OFFSETS_H
#define MUKCA_ARM_OFFSETS_H

#include <stdbool.h>

#include "arm/acceptance.h"
#include "arm/offset_lines.h"
#include "model/dataset.h"
#include "mukca/chain.h"
#include "mukca/corrected.h"
#include "mukca/effect.h"

enum {
    MUKCA_MAX_THETA = MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS,
    MUKCA_MAX_PLACEMENTS = 64,
    MUKCA_MAX_OFFSET_ROWS = MUKCA_MAX_THETA + MUKCA_MAX_TERMS * MUKCA_MAX_EFFECTS
};

typedef struct {
    /* parameters, by element of the chain: [6 * element + parameter] */
    double theta[MUKCA_MAX_THETA];
    double sigma[MUKCA_MAX_THETA];               /* infinite if not identifiable */
    unsigned char listed[MUKCA_MAX_THETA];       /* 1: has a row in the table */
    unsigned char identifiable[MUKCA_MAX_THETA]; /* of listed parameters */
    /* effects, and standard deviations of their coefficients */
    int n_effects;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    double effect_sigma[MUKCA_MAX_EFFECTS][MUKCA_MAX_TERMS];
    /* names of the effects' placement indices */
    int n_placements;
    char placements[MUKCA_MAX_PLACEMENTS][MUKCA_NAME_SIZE];
    mukca_acceptance acceptance; /* the verdict */
} mukca_offsets;

/* Initialise: theta nominal, no rows, no verdict. */
void mukca_offsets_init(mukca_offsets *offsets, const mukca_chain *chain);

/* Copy the names of a dataset's placements (the first MUKCA_MAX_PLACEMENTS), which effects of a
 * placement refer to. */
void mukca_offsets_set_placements(mukca_offsets *offsets, const mukca_dataset *data);

/* All rows in order: parameters by element, then effects.  rows[MUKCA_MAX_OFFSET_ROWS]; returns
 * their number.  `chain` owns the texts. */
int mukca_offsets_rows(mukca_offset_row *rows, const mukca_offsets *offsets,
                       const mukca_chain *chain);

/* Set the placement indices of effects[n_effects] to those of `data`; -1: not in the data. */
void mukca_offsets_place_effects(mukca_effect *effects, const mukca_offsets *offsets,
                                 const mukca_dataset *data);

/* Bits of `accept`: tables that are read, too. */
enum {
    MUKCA_ACCEPT_FAILED = 1, /* the calibration was not accepted */
    MUKCA_ACCEPT_EDITED = 2, /* the table was edited or cut: judged, and not accepted */
    MUKCA_ACCEPT_OTHER = 4   /* of another URDF or factory file: its offsets are applied, not its
                                calibrated values */
};

/* Origin of a table. */
typedef struct {
    const char *name; /* in: name of the table in messages */
    int accept;       /* in: MUKCA_ACCEPT_* */
    int ignored; /* out: number of rows of joints of the arm that are not in the chain (of another
                    --tip) */
    bool other, other_file; /* out: made for another URDF or factory file, by SHA-256 */
    bool other_ends;        /* out: made for another base or tip */
    mukca_chain *embedded;  /* out: the chain in the table's comments */
} mukca_offsets_origin;

/* Destination of a table. */
typedef struct {
    double *theta;         /* [6 * n_elements] */
    unsigned char *listed; /* [6 * n_elements], initialised as 0 */
    int *n_effects;
    mukca_effect *effects; /* [MUKCA_MAX_EFFECTS] */
    mukca_acceptance *acceptance;
    mukca_offsets *rest; /* for standard deviations and placement names; NULL: discard */
    /* called after the comments: is the table of `chain`?  NULL: not checked */
    mukca_status (*check)(mukca_offsets_origin *, const mukca_chain *chain, mukca_error *);
} mukca_offsets_target;

/* Parse a table of `size` bytes for the chain (NULL: origin->embedded). */
mukca_status mukca_offsets_parse_into(const mukca_offsets_target *into,
                                      mukca_offsets_origin *origin, const mukca_chain *chain,
                                      const char *text, size_t size, mukca_error *error);

/* Parse a table for the chain; if origin->embedded is given, for the chain in the table instead.
 * Errors: MUKCA_INPUT ("name:line: column ..."; a table that was not accepted, with its verdict in
 * offsets->acceptance; one that was edited or cut), MUKCA_MEMORY. */
mukca_status mukca_offsets_parse(mukca_offsets *offsets, mukca_offsets_origin *origin,
                                 const mukca_chain *chain, const char *text, mukca_error *error);

/* As mukca_corrected_parse, with the table's name in messages, and MUKCA_ACCEPT_*. */
mukca_status mukca_corrected_parse_named(mukca_corrected *model, const char *text, size_t size,
                                         const char *name, int accept, mukca_error *error);

#endif
