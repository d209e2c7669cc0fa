/* Writing a dataset as a session file or a pose log. */
#include "io/dataset.h"

#include <string.h>

#include "model/dataset_subset.h"

char mukca_dataset_separator(const char *path)
{
    const size_t length = strlen(path);
    return length > 4 && strcmp(path + length - 4, ".csv") == 0 ? ',' : '\t';
}

/* Write the line of a sample, -1: the header. */
static void write_line(FILE *stream, const mukca_dataset *data, const mukca_chain *chain,
                       char separator, int row)
{
    const mukca_socket *socket =
        row < 0 || !data->n_sockets ? NULL : &data->sockets[data->socket[row]];
    if (data->n_sockets)
        fprintf(stream, "%s%c%s%c", socket ? data->placements[socket->placement].name : "placement",
                separator, socket ? socket->label : "socket", separator);
    for (int c = 0; c < MUKCA_COLUMNS; c++) {
        const mukca_column *column = &mukca_column_table[c];
        const int width = mukca_column_width(c, data->n_joints);
        const double *values = data->column[c];
        for (int k = 0; k < width && values; k++) {
            if (c > 0) fputc(separator, stream);
            if (row >= 0)
                fprintf(stream, "%.*f", column->decimals,
                        values[(size_t)row * (size_t)width + (size_t)k]);
            else if (column->width)
                fputs(column->name[k], stream);
            else
                fprintf(stream, "%s%s", mukca_chain_joint_name(chain, k), column->name[0]);
        }
    }
    fputc('\n', stream);
}

void mukca_dataset_write(FILE *stream, const mukca_dataset *data, const mukca_chain *chain,
                         char separator)
{
    for (int row = -1; row < data->n_rows; row++) write_line(stream, data, chain, separator, row);
}
