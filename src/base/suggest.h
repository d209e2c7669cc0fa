/* Names that were meant: misspelt ones, and those that differ by a prefix. */
#ifndef MUKCA_BASE_SUGGEST_H
#define MUKCA_BASE_SUGGEST_H

#include <stddef.h>

/* Edits (insert, delete, replace, swap neighbours) from `a` to `b`, ignoring case; capped at 99. */
int mukca_suggest_distance(const char *a, const char *b);

/* True if `candidate` is near enough to `word` for a suggestion and nearer than *best (initially
 * 99), which is then updated. */
int mukca_suggest_better(int *best, const char *word, const char *candidate);

/* "did you mean MEANT?", or without MEANT (NULL) `otherwise`. */
enum { MUKCA_SUGGEST_TEXT = 128 };
const char *mukca_suggest_text(char text[MUKCA_SUGGEST_TEXT], const char *meant,
                               const char *otherwise);

/* ---- names that agree but for a common prefix, such as that of one of two arms ---- */

enum { MUKCA_PREFIX_NAME = 128 };

typedef struct {
    char add[64]; /* put before a name, */
    size_t cut;   /* after so many characters of it are removed */
} mukca_prefix;

/* Find the prefix by which each of wanted[n_wanted] becomes one of names[n_names]: none, one that
 * is added, or one that is cut.  It ends in a character that is no letter or digit.  Returns the
 * number of such prefixes; *prefix is the last. */
int mukca_prefix_find(mukca_prefix *prefix, const char *const *wanted, int n_wanted,
                      const char *const *names, int n_names);

/* The name with the prefix. */
void mukca_prefix_apply(char name[MUKCA_PREFIX_NAME], const mukca_prefix *prefix,
                        const char *wanted);

/* Whether `name` is `wanted`, or ends in it after a prefix. */
int mukca_prefix_ends(const char *name, const char *wanted);

#endif
