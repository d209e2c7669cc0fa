/* The offsets table: what a calibration found and what a diagnosis adds, with where it came from.
 */
#ifndef MUKCA_IO_OFFSETS_H
#define MUKCA_IO_OFFSETS_H

#include <stdbool.h>
#include <stdio.h>

#include "mukca/chain.h"
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
} mukca_offsets;

/* One row as it stands in the table and in JSON. */
typedef struct {
    const char *joint, *parameter, *unit; /* joint: "-" where an effect has none */
    double nominal, calibrated, offset, sigma;
    bool identifiable;
    char term[48]; /* which coefficient of an effect; "-" for a parameter */
} mukca_offset_row;

/* Nothing calibrated yet: theta nominal, no rows. */
void mukca_offsets_init(mukca_offsets *offsets, const mukca_chain *chain);

/* Copy the placements' names of a dataset, so that effects tied to a placement keep their meaning
 * (the first MUKCA_MAX_PLACEMENTS). */
void mukca_offsets_set_placements(mukca_offsets *offsets, const mukca_dataset *data);

/* All rows in order: parameters by element, then effects.  rows[MUKCA_MAX_OFFSET_ROWS]; returns
 * their number.  Texts belong to `chain`. */
int mukca_offsets_rows(mukca_offset_row *rows, const mukca_offsets *offsets,
                       const mukca_chain *chain);

/* Write the table.  `data` (may be NULL) names the files that it came from; `comments` (may be
 * NULL) is text whose lines are added as `#` lines. */
mukca_status mukca_offsets_write(FILE *stream, const mukca_offsets *offsets,
                                 const mukca_chain *chain, const mukca_dataset *data,
                                 const char *comments, mukca_error *error);

/* Read a table for the chain.  A table of another URDF (by SHA-256) is refused unless `force`; then
 * the offsets, not the calibrated values, are taken.  Rows of joints that are not in the chain (of
 * another --tip) are left out with a note.  `note` may be NULL.
 * Errors: MUKCA_INPUT (file, line, column), MUKCA_MEMORY. */
mukca_status mukca_offsets_read(mukca_offsets *offsets, const mukca_chain *chain, const char *path,
                                bool force, mukca_note_fn *note, void *context, mukca_error *error);

/* effects[n_effects] with the placement indices of `data`; -1 where it lacks the placement. */
void mukca_offsets_place_effects(mukca_effect *effects, const mukca_offsets *offsets,
                                 const mukca_dataset *data);

/* UTC time for provenance, "2026-01-31T12:00:00Z"; SOURCE_DATE_EPOCH is honoured. */
void mukca_offsets_time(char text[32]);

#endif
