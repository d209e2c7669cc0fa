/* Names of columns by --columns. */
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "io/table.h"

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

/* Take the unit of a name, if it states one; `axis (J1)`, with a digit, states none. */
static mukca_unit take_unit(mukca_table *t, char *name)
{
    const mukca_unit unit = mukca_unit_take(name);
    const char *open = name + strcspn(name, "[(");
    if (*open && !open[strcspn(open, "0123456789")])
        mukca_table_fail(t, -1, "--columns: '%.40s' is no unit that is read; convert the column",
                         open);
    return unit;
}

static void name_column(mukca_table *t, int column, char *name)
{
    const mukca_unit unit = take_unit(t, name);
    if (unit.factor > 0) t->unit[column] = unit;
    t->header[column] = name;
}

/* Apply COLUMN=NAME to the column that was called so `before` all renames. */
static void rename_column(mukca_table *t, char **before, char *entry, char *equals)
{
    *equals = '\0';
    char *rest = equals + 1, *name = next_entry(&rest);
    entry = next_entry(&entry);
    if (!entry || !name) {
        mukca_table_fail(t, -1, "--columns: write COLUMN=NAME");
        return;
    }
    (void)take_unit(t, entry);
    int c = 0;
    while (c < t->n_columns && !(before[c] && strcmp(before[c], entry) == 0)) c++;
    if (c == t->n_columns) {
        mukca_table_fail(t, -1, "no column '%.60s', which --columns renames", entry);
        return;
    }
    name_column(t, c, name);
    before[c] = name + strlen(name);
}

/* Apply a list of names and renames; returns the number of names. */
static int apply(mukca_table *t, char **before)
{
    char *list = t->names, *entry;
    int named = 0;
    while (t->status == MUKCA_OK && (entry = next_entry(&list))) {
        char *equals = strchr(entry, '=');
        if (!*entry || *entry == '#') continue;
        if (equals)
            rename_column(t, before, entry, equals);
        else if (named++ < t->n_columns)
            name_column(t, named - 1, entry);
    }
    return named;
}

void mukca_columns_rename(mukca_table *t, const char *columns)
{
    const size_t width = (size_t)t->n_columns + 1;
    if (!strchr(columns, '=') && access(columns, R_OK) == 0)
        mukca_table_stop(t, mukca_file_read(&t->names, columns, t->error));
    else
        t->names = strdup(columns);
    if (!t->header) t->header = MUKCA_TAKE(&t->pool, char *, width);
    if (!t->unit) t->unit = MUKCA_TAKE(&t->pool, mukca_unit, width);
    char **before = MUKCA_TAKE(&t->pool, char *, width);
    if (t->status == MUKCA_OK && (!t->names || t->pool.failed))
        mukca_table_stop(t, mukca_fail(t->error, MUKCA_MEMORY, "out of memory"));
    const bool ready = t->status == MUKCA_OK;
    for (int c = 0; c < t->n_columns && ready; c++)
        before[c] = t->header[c] =
            t->header[c] ? t->header[c] : t->names + strlen(t->names); /* a name that nothing has */
    const int named = ready ? apply(t, before) : 0;
    if (named > 0 && named != t->n_columns)
        mukca_table_fail(t, -1,
                         "--columns %.40s names %d columns, but the table has %d; name all, or "
                         "rename some, as in 'q1=joint_1,q2=joint_2'",
                         columns, named, t->n_columns);
    mukca_table_check_names(t);
}
