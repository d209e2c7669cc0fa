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

enum { MUKCA_POSE_NUMBERS = 7 }; /* of a pose, at most: position, and a quaternion */

/* A target in a line. */
typedef struct {
    size_t begin, end;                  /* its text: line[begin .. end) */
    size_t number[MUKCA_MAX_JOINTS][2]; /* the text of each number; empty: carried over */
    bool partial;                       /* numbers were carried over */
    bool incomplete;                    /* some are missing, and the target before is unknown */
    double value[MUKCA_MAX_JOINTS];     /* of each number, in the program's units */
    double q[MUKCA_MAX_JOINTS];         /* of a joint target: rad, or m of a joint that slides */
    mukca_frame pose;                   /* of a pose: m */
} mukca_program_target;

/* What is read of a program, line by line. */
typedef struct {
    const mukca_language *language;
    const mukca_chain *chain;
    bool pose; /* poses, not joint targets */
    /* the line, and the target of the last move */
    const char *line;
    size_t at;
    bool moves, relative, found, known;
    double last[MUKCA_MAX_JOINTS]; /* as in the program */
} mukca_program_reader;

/* Begin a line, which must outlive the calls of mukca_program_next. */
void mukca_program_line(mukca_program_reader *reader, const char *line);

/* The next joint target of the chain (or pose) in the line; false: there is none.  Comments are
 * passed over, and poses that are no targets: relative moves and frames of tools and bases in KRL,
 * a quaternion of another length than 1.  KRL may leave out components; those are the values of the
 * last move, as on the controller. */
bool mukca_program_next(mukca_program_target *target, mukca_program_reader *reader);

/* The most joints that a joint target has room for. */
int mukca_language_axes(const mukca_language *language);

/* Print q[n_joints] as a joint target: a whole line of a program, without its end. */
void mukca_language_print(FILE *stream, const mukca_language *language, const mukca_chain *chain,
                          const double *q);

/* Print the text of the reader's target with the joints' values replaced by q[n_joints]; axes of
 * the target that the chain lacks stay. */
void mukca_language_replace(FILE *stream, const mukca_program_reader *reader,
                            const mukca_program_target *target, const double *q);

/* The same for a pose.  Configuration, and axes of other machines, stay. */
void mukca_language_replace_pose(FILE *stream, const mukca_program_reader *reader,
                                 const mukca_program_target *target, const mukca_frame *pose);

#endif
