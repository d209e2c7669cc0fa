/* Lines of an offsets table: the arm in its comments, and its rows. */
#ifndef MUKCA_ARM_OFFSET_LINES_H
#define MUKCA_ARM_OFFSET_LINES_H

#include <stdio.h>

#include "mukca/chain.h"

/* One row of the table, or object in JSON. */
typedef struct {
    const char *joint, *parameter, *unit; /* joint: "-" for an effect without */
    double nominal, calibrated, offset, sigma;
    bool identifiable;
    char term[48]; /* coefficient of an effect (MUKCA_EFFECT_TEXT); "-" for a parameter */
} mukca_offset_row;

/* The row of parameter `index` of theta, without standard deviation. */
mukca_offset_row mukca_offset_row_parameter(const mukca_chain *chain, int index, double calibrated);

/* Comment line of a key, as "robot: ", and a text, without control characters. */
void mukca_offset_line(FILE *stream, const char *key, const char *text);

/* Comment lines of the arm's names; of the whole chain: a reader needs no URDF. */
void mukca_offset_lines_names(FILE *stream, const mukca_chain *chain);
void mukca_offset_lines_chain(FILE *stream, const mukca_chain *chain);

/* Names of the columns; one row. */
void mukca_offset_lines_columns(FILE *stream);
void mukca_offset_lines_row(FILE *stream, const mukca_offset_row *row);

#endif
