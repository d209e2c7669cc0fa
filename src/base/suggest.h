/* Suggestion of the intended name for a misspelt one. */
#ifndef MUKCA_BASE_SUGGEST_H
#define MUKCA_BASE_SUGGEST_H

/* Edits (insert, delete, replace, swap neighbours) from `a` to `b`, ignoring case; capped at 99. */
int mukca_suggest_distance(const char *a, const char *b);

/* True if `candidate` is near enough to `word` for a suggestion and nearer than *best (initially
 * 99), which is then updated. */
int mukca_suggest_better(int *best, const char *word, const char *candidate);

/* "did you mean MEANT?", or without MEANT (NULL) `otherwise`. */
enum { MUKCA_SUGGEST_TEXT = 128 };
const char *mukca_suggest_text(char text[MUKCA_SUGGEST_TEXT], const char *meant,
                               const char *otherwise);

#endif
