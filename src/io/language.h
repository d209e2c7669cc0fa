/* Targets in the languages of robot programs.  A language is one row in language.c. */
#ifndef MUKCA_IO_LANGUAGE_H
#define MUKCA_IO_LANGUAGE_H

#include <stdio.h>

#include "mukca/chain.h"

/* name, what it holds */
#define MUKCA_LANGUAGE_LIST(X)                                                 \
    X(rapid, "ABB, jointtargets [[j1,...],[9E9,...]] and robtargets; deg, mm") \
    X(krl, "KUKA, axes {A1 ..,A2 ..} and frames {X ..,Y ..,Z ..}; deg, mm")    \
    X(urscript, "UR, moves to [q1,...] and p[x,y,z,rx,ry,rz]; rad, m")

typedef struct mukca_language mukca_language;
extern const mukca_language *const mukca_languages[]; /* in the order of the list; no end */

/* A target in a line. */
typedef struct {
    size_t begin, end;                  /* its text: line[begin .. end) */
    size_t number[MUKCA_MAX_JOINTS][2]; /* of a joint target: the text of each joint's value */
    double q[MUKCA_MAX_JOINTS];         /* of a joint target: rad, or m of a joint that slides */
    mukca_frame pose;                   /* of a pose: m */
} mukca_program_target;

/* Find the first joint target of the chain (or pose) in the line at or after `from`; false: there
 * is none.  Comments are passed over; a pose whose quaternion has another length than 1 is none. */
bool mukca_language_find(mukca_program_target *target, const mukca_language *language,
                         const mukca_chain *chain, bool pose, const char *line, size_t from);

/* The moves of the language that take a joint target but no pose, as a text; NULL: they take both.
 */
const char *mukca_language_joint_move(const mukca_language *language);

/* Print q[n_joints] as a joint target; `alone`: as a whole line of a program, without its end. */
void mukca_language_print(FILE *stream, const mukca_language *language, const mukca_chain *chain,
                          const double *q, bool alone);

/* Print the target's text with the joints' values replaced by q[n_joints]; axes of the target that
 * the chain lacks stay. */
void mukca_language_replace(FILE *stream, const mukca_language *language, const mukca_chain *chain,
                            const mukca_program_target *target, const char *line, const double *q);

#endif
