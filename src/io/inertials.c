/* Link masses from a table. */
#include "io/inertials.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "io/table.h"

static mukca_status read_row(mukca_inertial *row, const mukca_table *table, const int column[5],
                             mukca_error *error)
{
    const char *link = table->cell[column[0]];
    if (!*link || strlen(link) >= sizeof row->link)
        return mukca_table_fail(error, table, column[0],
                                "the name of a link has 1 to 63 characters");
    snprintf(row->link, sizeof row->link, "%s", link);
    double value[4];
    for (int i = 0; i < 4; i++) {
        mukca_status status = mukca_table_number(&value[i], table, column[1 + i], error);
        if (status != MUKCA_OK) return status;
        if (fabs(value[i]) > MUKCA_NUMBER_LARGEST)
            return mukca_table_fail(error, table, column[1 + i],
                                    "%g is larger than any arm's; masses are in kg, lengths in m",
                                    value[i]);
    }
    if (value[0] < 0) return mukca_table_fail(error, table, column[1], "a mass cannot be negative");
    row->kg = value[0];
    memcpy(row->com, value + 1, sizeof row->com);
    return MUKCA_OK;
}

mukca_status mukca_inertials_read(mukca_inertial **list, int *n, const char *path,
                                  mukca_error *error)
{
    static const char *const names[5] = {"link", "mass_kg", "com_x_m", "com_y_m", "com_z_m"};
    mukca_table table;
    int column[5], count = 0;
    mukca_inertial *rows = NULL;
    mukca_status status = mukca_table_open(&table, path, MUKCA_HEADER, error);
    for (int i = 0; i < 5 && status == MUKCA_OK; i++)
        status = mukca_table_require(&column[i], &table, names[i], error);
    while (status == MUKCA_OK) {
        bool more;
        status = mukca_table_next(&table, &more, error);
        if (status != MUKCA_OK || !more) break;
        mukca_inertial *grown = realloc(rows, (size_t)(count + 1) * sizeof *rows);
        if (!grown) {
            status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
            break;
        }
        rows = grown;
        status = read_row(&rows[count], &table, column, error);
        for (int i = 0; i < count && status == MUKCA_OK; i++)
            if (strcmp(rows[i].link, rows[count].link) == 0)
                status = mukca_table_fail(error, &table, column[0], "link '%s' has a row already",
                                          rows[i].link);
        count++;
    }
    mukca_table_close(&table);
    if (status != MUKCA_OK) {
        free(rows);
        rows = NULL;
        count = 0;
    }
    *list = rows;
    *n = count;
    return status;
}
