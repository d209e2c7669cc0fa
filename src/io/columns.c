/* Names of the columns of tables from other programs. */
#include "io/table.h"

#include <stdlib.h>
#include <string.h>

#include "base/cells.h"
#include "base/file.h"

/* The next entry of a list, trimmed; NULL at its end. */
static char *next_entry(char **list)
{
    char *entry = *list + strspn(*list, " \t"), *end = entry + strcspn(entry, ",\r\n");
    if (!*entry) return NULL;
    *list = end + (*end != '\0');
    *end = '\0';
    while (end > entry && (end[-1] == ' ' || end[-1] == '\t')) *--end = '\0';
    return entry;
}

static void rename_column(mukca_table *t, char *entry, char *equals)
{
    char *name = equals + 1 + strspn(equals + 1, " \t");
    for (*equals = '\0'; equals > entry && (equals[-1] == ' ' || equals[-1] == '\t');)
        *--equals = '\0';
    (void)mukca_unit_take(entry);
    const int column = mukca_table_find(t, entry);
    if (column >= 0)
        t->header[column] = name;
    else
        mukca_table_fail(t, -1, "no column '%.60s', which --columns renames", entry);
}

void mukca_columns_rename(mukca_table *t, const char *columns)
{
    FILE *file = strchr(columns, '=') ? NULL : fopen(columns, "r");
    int named = 0;
    if (file) {
        fclose(file);
        mukca_table_stop(t, mukca_file_read(&t->names, columns, t->error));
    } else {
        t->names = strdup(columns);
    }
    if (!t->header) t->header = calloc((size_t)t->n_columns + 1, sizeof *t->header);
    if (t->status != MUKCA_OK) return;
    if (!t->names || !t->header) {
        mukca_table_stop(t, mukca_fail(t->error, MUKCA_MEMORY, "out of memory"));
        return;
    }
    char *list = t->names, *entry;
    for (int c = 0; c < t->n_columns; c++)
        if (!t->header[c]) t->header[c] = list + strlen(list); /* a name that nothing has */
    while ((entry = next_entry(&list))) {
        char *equals = strchr(entry, '=');
        if (!*entry || *entry == '#') continue;
        if (equals)
            rename_column(t, entry, equals);
        else if (named++ < t->n_columns)
            t->header[named - 1] = entry;
    }
    if (named > 0 && named != t->n_columns)
        mukca_table_fail(t, -1,
                         "--columns %.40s names %d columns, but the table has %d; name all, or "
                         "rename some, as in 'q1=joint_1,q2=joint_2'",
                         columns, named, t->n_columns);
}
