/* Targets in the languages of robot programs.  A language is one row in language.c. */
#ifndef MUKCA_IO_LANGUAGE_H
#define MUKCA_IO_LANGUAGE_H

#include <stdio.h>

#include "mukca/chain.h"

/* name, kind of targets */
#define MUKCA_LANGUAGE_LIST(X)                                                 \
    X(rapid, "ABB, jointtargets [[j1,...],[9E9,...]] and robtargets; deg, mm") \
    X(krl, "KUKA, axes {A1 ..,A2 ..} and frames {X ..,Y ..,Z ..}; deg, mm")    \
    X(urscript, "UR, moves to [q1,...] and p[x,y,z,rx,ry,rz]; rad, m")

typedef struct mukca_language mukca_language;
extern const mukca_language *const mukca_languages[]; /* in the order of the list */

enum { MUKCA_POSE_NUMBERS = 7 }; /* largest number, of a pose: position and quaternion */

/* A target in a line. */
typedef struct {
    size_t begin, end;                  /* text of the target: line[begin .. end) */
    size_t number[MUKCA_MAX_JOINTS][2]; /* text of each number; empty: carried over */
    bool partial;                       /* some numbers were carried over */
    bool incomplete; /* some numbers are omitted, and the preceding target is unknown */
    double value[MUKCA_MAX_JOINTS]; /* of each number, in the program's units */
    double q[MUKCA_MAX_JOINTS];     /* of a joint target: rad, or m for a prismatic joint */
    mukca_frame pose;               /* of a pose: m */
} mukca_program_target;

/* Reader of a program, line by line. */
typedef struct {
    const mukca_language *language;
    const mukca_chain *chain;
    bool pose; /* read poses instead of joint targets */
    /* internal: the current line, and the target of the last move */
    const char *line;
    size_t at;
    bool moves, relative, found, known;
    double last[MUKCA_MAX_JOINTS]; /* in the program's units */
} mukca_program_reader;

/* Start a line, which must outlive the calls of mukca_program_next. */
void mukca_program_line(mukca_program_reader *reader, const char *line);

/* The next joint target (or pose) in the line; false: none.  Comments are skipped, and poses that
 * are not targets: in KRL relative moves and frames of tools and bases; elsewhere quaternions not
 * of length 1.  Components that KRL omits are those of the last move, as on the controller. */
bool mukca_program_next(mukca_program_target *target, mukca_program_reader *reader);

/* Largest number of axes of a joint target. */
int mukca_language_axes(const mukca_language *language);

/* Print q[n_joints] as a joint target: a complete line of a program, without its end. */
void mukca_language_print(FILE *stream, const mukca_language *language, const mukca_chain *chain,
                          const double *q);

/* Print the text of the reader's target with the joint values replaced by q[n_joints]; axes that
 * the chain lacks are unchanged. */
void mukca_language_replace(FILE *stream, const mukca_program_reader *reader,
                            const mukca_program_target *target, const double *q);

/* The same for a pose.  Configuration and external axes are unchanged. */
void mukca_language_replace_pose(FILE *stream, const mukca_program_reader *reader,
                                 const mukca_program_target *target, const mukca_frame *pose);

#endif
