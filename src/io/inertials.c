/* Link masses from a table. */
#include "io/urdf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/list.h"
#include "base/number.h"
#include "io/table.h"

typedef struct {
    mukca_inertial *rows;
    int n;
} list;

static void read_row(void *context, mukca_table *table, const int *column)
{
    list *l = context;
    const char *link = table->cell[column[0]];
    mukca_inertial row = {.link = ""};
    double *const value[4] = {&row.kg, &row.com[0], &row.com[1], &row.com[2]};
    if (!*link || strlen(link) >= MUKCA_NAME_SIZE)
        mukca_table_fail(table, column[0], "the name of a link has 1 to 63 characters");
    for (int i = 0; i < l->n; i++)
        if (strcmp(l->rows[i].link, link) == 0)
            mukca_table_fail(table, column[0], "link '%s' has a row already", link);
    for (int i = 0; i < 4; i++) {
        *value[i] = mukca_table_number(table, column[1 + i]);
        if (fabs(*value[i]) > MUKCA_NUMBER_LARGEST)
            mukca_table_fail(table, column[1 + i],
                             "%g is larger than any arm's; masses are in kg, lengths in m",
                             *value[i]);
    }
    if (row.kg < 0) mukca_table_fail(table, column[1], "a mass cannot be negative");
    if (table->status != MUKCA_OK) return;
    memcpy(row.link, link, strlen(link) + 1);
    mukca_inertial *added = mukca_list_append(&l->rows, &l->n, sizeof *added);
    if (added)
        *added = row;
    else
        mukca_table_stop(table, mukca_fail(table->error, MUKCA_MEMORY, "out of memory"));
}

mukca_status mukca_inertials_read(mukca_inertial **rows, int *n, const char *path,
                                  mukca_error *error)
{
    static const char *const names[] = {"link", "mass_kg", "com_x_m", "com_y_m", "com_z_m"};
    list l = {0};
    const mukca_status status = mukca_table_read(path, names, 5, read_row, &l, error);
    if (status != MUKCA_OK) {
        free(l.rows);
        l = (list){0};
    }
    *rows = l.rows;
    *n = l.n;
    return status;
}
