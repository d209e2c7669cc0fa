/* Names that were meant: misspelt ones, and those that differ by a prefix. */
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
    snprintf(text, MUKCA_SUGGEST_TEXT, meant ? "did you mean %.80s?" : "%s",
             meant ? meant : otherwise);
    return text;
}

/* ---- prefixes ---- */

void mukca_prefix_apply(char name[MUKCA_PREFIX_NAME], const mukca_prefix *prefix,
                        const char *wanted)
{
    const size_t length = strlen(wanted), cut = prefix->cut < length ? prefix->cut : length;
    snprintf(name, MUKCA_PREFIX_NAME, "%s%s", prefix->add, wanted + cut);
}

int mukca_prefix_ends(const char *name, const char *wanted)
{
    const size_t length = strlen(name), tail = strlen(wanted);
    if (length < tail || tail == 0 || strcmp(name + length - tail, wanted) != 0) return 0;
    return length == tail || !isalnum((unsigned char)name[length - tail - 1]);
}

/* Whether all of `wanted` are names with this prefix. */
static int fits(const mukca_prefix *p, const char *const *wanted, int n_wanted,
                const char *const *names, int n_names)
{
    for (int i = 0; i < n_wanted; i++) {
        char name[MUKCA_PREFIX_NAME];
        int k = 0;
        if (strncmp(wanted[i], wanted[0], p->cut) != 0) return 0;
        mukca_prefix_apply(name, p, wanted[i]);
        while (k < n_names && strcmp(names[k], name) != 0) k++;
        if (k == n_names) return 0;
    }
    return 1;
}

int mukca_prefix_find(mukca_prefix *prefix, const char *const *wanted, int n_wanted,
                      const char *const *names, int n_names)
{
    int found = 0;
    *prefix = (mukca_prefix){.cut = 0};
    if (n_wanted == 0 || fits(prefix, wanted, n_wanted, names, n_names)) return 1;
    for (int k = 0; k < n_names; k++) {
        const size_t length = strlen(names[k]), first = strlen(wanted[0]);
        mukca_prefix p = {.cut = 0};
        if (mukca_prefix_ends(names[k], wanted[0]) && length - first < sizeof p.add)
            memcpy(p.add, names[k], length - first);
        else if (mukca_prefix_ends(wanted[0], names[k]))
            p.cut = first - length;
        else
            continue;
        if (!fits(&p, wanted, n_wanted, names, n_names)) continue;
        *prefix = p;
        found++;
    }
    return found;
}
