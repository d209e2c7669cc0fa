/* Targets in the languages of robot programs.  A language is one row in language.c. */
#ifndef MUKCA_IO_LANGUAGE_H
#define MUKCA_IO_LANGUAGE_H

#include <stdio.h>

#include "mukca/chain.h"

/* name, kind of targets */
#define MUKCA_LANGUAGE_LIST(X)                                  \
    X(rapid, "ABB, jointtargets [[j1,...],[9E9,...]]; deg, mm") \
    X(krl, "KUKA, axes {A1 ..,A2 ..}; deg, mm")                 \
    X(urscript, "UR, lists [q1,...]; rad, m")

typedef struct mukca_language mukca_language;
extern const mukca_language *const mukca_languages[]; /* in the order of the list */

typedef enum {
    MUKCA_LINE_UNKNOWN, /* could move the arm, for all that the reader knows */
    MUKCA_LINE_TARGET,
    MUKCA_LINE_OTHER /* does not move the arm */
} mukca_program_line;

/* A target in a line. */
typedef struct {
    size_t number[MUKCA_MAX_JOINTS][2]; /* text of each joint's value: line[number[0] .. [1]) */
    double q[MUKCA_MAX_JOINTS];         /* rad, or m for a prismatic joint */
} mukca_program_target;

/* Read a line of a program, which moves the arm to a joint target in numbers or not at all, or
 * consists of a target alone.  Poses depend on the program's tool and frame and are unknown. */
mukca_program_line mukca_language_read(mukca_program_target *target, const mukca_language *language,
                                       const mukca_chain *chain, const char *line);

/* Largest number of axes of a joint target. */
int mukca_language_axes(const mukca_language *language);

/* Print the line with the values of the target's joints replaced by q[n_joints]. */
void mukca_language_replace(FILE *stream, const mukca_language *language, const mukca_chain *chain,
                            const char *line, const mukca_program_target *target, const double *q);

#endif
