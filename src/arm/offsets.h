/* The offsets table: what a calibration found and what a diagnosis adds, with where it came from.
 */
#ifndef MUKCA_ARM_OFFSETS_H
#define MUKCA_ARM_OFFSETS_H

#include <stdbool.h>

#include "arm/acceptance.h"
#include "mukca/chain.h"
#include "mukca/corrected.h"
#include "mukca/dataset.h"
#include "mukca/effect.h"

enum {
    MUKCA_MAX_THETA = MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS,
    MUKCA_MAX_PLACEMENTS = 64,
    MUKCA_MAX_OFFSET_ROWS = MUKCA_MAX_THETA + MUKCA_MAX_TERMS * MUKCA_MAX_EFFECTS
};

typedef struct {
    /* parameters, by element of the chain: [6 * element + parameter] */
    double theta[MUKCA_MAX_THETA];
    double sigma[MUKCA_MAX_THETA];               /* infinite where not identifiable */
    unsigned char listed[MUKCA_MAX_THETA];       /* 1: has a row in the table */
    unsigned char identifiable[MUKCA_MAX_THETA]; /* of listed ones */
    /* effects, and the sigmas of their coefficients */
    int n_effects;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    double effect_sigma[MUKCA_MAX_EFFECTS][MUKCA_MAX_TERMS];
    /* names that the effects' placement indices mean */
    int n_placements;
    char placements[MUKCA_MAX_PLACEMENTS][MUKCA_NAME_SIZE];
    mukca_acceptance acceptance; /* may it be used? */
} mukca_offsets;

/* One row of the table, or object in JSON. */
typedef struct {
    const char *joint, *parameter, *unit; /* joint: "-" where an effect has none */
    double nominal, calibrated, offset, sigma;
    bool identifiable;
    char term[MUKCA_EFFECT_TEXT]; /* which coefficient of an effect; "-" for a parameter */
} mukca_offset_row;

/* Nothing calibrated yet: theta nominal, no rows, no verdict. */
void mukca_offsets_init(mukca_offsets *offsets, const mukca_chain *chain);

/* Copy the placements' names of a dataset, so that effects tied to a placement keep their meaning
 * (the first MUKCA_MAX_PLACEMENTS). */
void mukca_offsets_set_placements(mukca_offsets *offsets, const mukca_dataset *data);

/* All rows in order: parameters by element, then effects.  rows[MUKCA_MAX_OFFSET_ROWS]; returns
 * their number.  Texts belong to `chain`. */
int mukca_offsets_rows(mukca_offset_row *rows, const mukca_offsets *offsets,
                       const mukca_chain *chain);

/* effects[n_effects] with the placement indices of `data`; -1 where it lacks the placement. */
void mukca_offsets_place_effects(mukca_effect *effects, const mukca_offsets *offsets,
                                 const mukca_dataset *data);

/* Origin of a table. */
typedef struct {
    const char *name; /* in: what messages call the table */
    bool force;       /* in: take the offsets (not the calibrated values) of another URDF's table */
    bool accept_failed; /* in: take a table that did not pass, too */
    bool other;         /* out: it is another URDF's, by SHA-256 */
    int ignored;        /* out: rows of joints that are not in the chain (of another --tip) */
} mukca_offsets_origin;

/* A text of `size` bytes; no NUL is needed. */
typedef struct {
    const char *text;
    size_t size;
} mukca_bytes;

/* Where a table is read into. */
typedef struct {
    double *theta;                /* [6 * n_elements], nominal before */
    unsigned char *listed;        /* [6 * n_elements], zero before */
    int *n_effects;               /* 0 before */
    mukca_effect *effects;        /* [MUKCA_MAX_EFFECTS] */
    mukca_acceptance *acceptance; /* initialised before */
    mukca_offsets *rest;          /* sigmas and names of placements; NULL: not kept */
} mukca_offsets_target;

mukca_status mukca_offsets_parse_into(const mukca_offsets_target *into,
                                      mukca_offsets_origin *origin, const mukca_chain *chain,
                                      mukca_bytes table, mukca_error *error);

/* Read a table for the chain from its text.  Errors: MUKCA_INPUT ("name:line: column ..."; a table
 * that did not pass, whose verdict is then in offsets->acceptance). */
mukca_status mukca_offsets_parse(mukca_offsets *offsets, mukca_offsets_origin *origin,
                                 const mukca_chain *chain, const char *text, mukca_error *error);

/* The chain from the comment lines of a table.  Errors: MUKCA_INPUT. */
mukca_status mukca_chain_parse(mukca_chain *chain, mukca_bytes table, const char *name,
                               mukca_error *error);

/* As mukca_corrected_parse_any, of a table with that origin. */
mukca_status mukca_corrected_parse_from(mukca_corrected *model, mukca_bytes table,
                                        const mukca_offsets_origin *from, mukca_error *error);

#endif
