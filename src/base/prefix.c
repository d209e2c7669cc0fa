/* Names that agree but for a common prefix. */
#include "base/prefix.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

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
