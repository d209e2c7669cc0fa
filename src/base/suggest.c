/* Edit distance (optimal string alignment) for suggestions. */
#include "base/suggest.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

enum { LONGEST = 63 };

int mukca_suggest_distance(const char *a, const char *b)
{
    size_t m = strlen(a), n = strlen(b);
    if (m > LONGEST || n > LONGEST) return 99;
    int row[3][LONGEST + 1]; /* last but one, last, current */
    for (size_t j = 0; j <= n; j++) row[1][j] = (int)j;
    for (size_t i = 1; i <= m; i++) {
        row[2][0] = (int)i;
        for (size_t j = 1; j <= n; j++) {
            int x = tolower((unsigned char)a[i - 1]), y = tolower((unsigned char)b[j - 1]);
            int best = row[1][j - 1] + (x != y);
            if (row[1][j] + 1 < best) best = row[1][j] + 1;
            if (row[2][j - 1] + 1 < best) best = row[2][j - 1] + 1;
            if (i > 1 && j > 1 && x == tolower((unsigned char)b[j - 2]) &&
                y == tolower((unsigned char)a[i - 2]) && row[0][j - 2] + 1 < best)
                best = row[0][j - 2] + 1;
            row[2][j] = best;
        }
        memcpy(row[0], row[1], sizeof row[0]);
        memcpy(row[1], row[2], sizeof row[0]);
    }
    return row[1][n];
}

int mukca_suggest_better(int *best, const char *word, const char *candidate)
{
    int distance = mukca_suggest_distance(word, candidate);
    int limit = (int)strlen(word) / 3 + 1;
    /* a prefix counts as near: "cal" for "calibrate" */
    if (strlen(word) >= 3 && strncmp(word, candidate, strlen(word)) == 0) distance = 1;
    if (distance > limit || distance >= *best) return 0;
    *best = distance;
    return 1;
}

const char *mukca_suggest_text(char text[MUKCA_SUGGEST_TEXT], const char *meant,
                               const char *otherwise)
{
    if (meant)
        snprintf(text, MUKCA_SUGGEST_TEXT, "did you mean %.80s?", meant);
    else
        snprintf(text, MUKCA_SUGGEST_TEXT, "%s", otherwise);
    return text;
}
