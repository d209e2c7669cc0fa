/* The verdict of an offsets table: reading it from comment lines. */
#include "arm/acceptance.h"

#include <math.h>
#include <string.h>

#include "base/number.h"

#define KEY(key) #key,
const char *const mukca_acceptance_key[MUKCA_ACCEPTANCE_NUMBERS] = {MUKCA_ACCEPTANCE_LIST(KEY)};

void mukca_acceptance_init(mukca_acceptance *a)
{
    memset(a, 0, sizeof *a);
    for (int i = 0; i < MUKCA_ACCEPTANCE_NUMBERS; i++) a->number[i] = NAN;
}

static void refuse(mukca_acceptance *a, const char *reason)
{
    mukca_print(a->reason, sizeof a->reason, "%s", reason);
    a->given = true;
    a->accepted = false;
}

/* The text after "# KEY: " in a line; NULL: another line. */
static const char *value_of(const char *line, const char *key)
{
    const size_t length = strlen(key);
    if (strncmp(line, "# ", 2) != 0 || strncmp(line + 2, key, length) != 0) return NULL;
    return strncmp(line + 2 + length, ": ", 2) == 0 ? line + length + 4 : NULL;
}

void mukca_acceptance_read(mukca_acceptance *a, const char *line)
{
    const char *text = value_of(line, "accepted");
    if (text && strcmp(text, "yes") == 0) {
        a->accepted = !a->given || a->accepted; /* a preceding refusal remains */
        a->given = true;
    } else if (text) {
        text += strncmp(text, "no; ", 4) == 0 ? 4 : 0;
        refuse(a, text);
    } else if (strcmp(line, "# NOT CONVERGED") == 0) { /* of the first release */
        refuse(a, "NOT CONVERGED");
    }
    text = value_of(line, "converged");
    if (text) a->converged = strcmp(text, "yes") == 0;
    text = value_of(line, "error_of");
    if (text) mukca_print(a->error_of, sizeof a->error_of, "%.63s", text);
    text = value_of(line, "joints_at_rest");
    if (text) mukca_print(a->at_rest, sizeof a->at_rest, "%.95s", text);
    for (int i = 0; i < MUKCA_ACCEPTANCE_NUMBERS; i++) {
        text = value_of(line, mukca_acceptance_key[i]);
        if (text && !mukca_number_parse(&a->number[i], text)) a->number[i] = NAN;
    }
}
