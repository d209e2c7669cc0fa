/* Writing a dataset as a session file or a pose log. */
#include "io/dataset.h"

#include <string.h>

enum { COLUMNS = 7 };

char mukca_dataset_separator(const char *path)
{
    const size_t length = strlen(path);
    return length > 4 && strcmp(path + length - 4, ".csv") == 0 ? ',' : '\t';
}

/* A block of columns: one per joint, or named. */
typedef struct {
    const double *values;
    int width;         /* values per sample */
    int decimals;      /* digits after the decimal point */
    const char *names; /* column names separated by `|`; NULL: those of the joints */
    const char *suffix;
} block;

static void write_names(FILE *stream, const block *b, const mukca_chain *chain, char separator)
{
    if (!b->names)
        for (int j = 0; j < b->width; j++)
            fprintf(stream, "%c%s%s", separator, mukca_chain_joint_name(chain, j), b->suffix);
    else
        for (const char *c = b->names; *c; c++) fputc(*c == '|' ? separator : *c, stream);
}

void mukca_dataset_write(FILE *stream, const mukca_dataset *data, const mukca_chain *chain,
                         char separator)
{
    const int n = data->n_joints;
    const block blocks[COLUMNS] = {{data->q, n, 12, NULL, ""},
                                   {data->effort, n, 6, NULL, ".effort"},
                                   {data->command, n, 12, NULL, ".command"},
                                   {data->velocity, n, 9, NULL, ".velocity"},
                                   {data->payload, 1, 6, "|payload_kg", NULL},
                                   {data->position, 3, 12, "|x_m|y_m|z_m", NULL},
                                   {data->quaternion, 4, 14, "|qw|qx|qy|qz", NULL}};
    if (data->n_sockets) fprintf(stream, "placement%csocket%c", separator, separator);
    fputs("time_s", stream);
    for (int b = 0; b < COLUMNS; b++)
        if (blocks[b].values) write_names(stream, &blocks[b], chain, separator);
    fputc('\n', stream);
    for (int i = 0; i < data->n_rows; i++) {
        if (data->n_sockets)
            fprintf(stream, "%s%c%s%c", data->placements[mukca_dataset_placement(data, i)].name,
                    separator, data->sockets[data->socket[i]].label, separator);
        fprintf(stream, "%.3f", data->time[i]);
        for (int b = 0; b < COLUMNS; b++)
            for (int k = 0; k < blocks[b].width && blocks[b].values; k++)
                fprintf(stream, "%c%.*f", separator, blocks[b].decimals,
                        blocks[b].values[(size_t)i * (size_t)blocks[b].width + (size_t)k]);
        fputc('\n', stream);
    }
}
