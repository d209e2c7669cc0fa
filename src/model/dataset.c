/* Datasets: allocation, freeing. */
#include "model/dataset.h"

#include <stdlib.h>
#include <string.h>

/* calloc of at least one byte: NULL means out of memory. */
static void *zeros(size_t count, size_t size)
{
    return calloc(count ? count : 1, size);
}

mukca_status mukca_dataset_create(mukca_dataset *data, int n_rows, int n_joints, int n_sockets,
                                  int n_placements, mukca_error *error)
{
    memset(data, 0, sizeof *data);
    data->n_rows = n_rows;
    data->n_joints = n_joints;
    data->n_sockets = n_sockets;
    data->n_placements = n_placements;
    size_t rows = (size_t)n_rows;
    data->q = zeros(rows * (size_t)n_joints, sizeof *data->q);
    data->socket = zeros(rows, sizeof *data->socket);
    data->row = zeros(rows, sizeof *data->row);
    data->file = zeros(rows, sizeof *data->file);
    data->sockets = zeros((size_t)n_sockets, sizeof *data->sockets);
    data->placements = zeros((size_t)n_placements, sizeof *data->placements);
    if (!data->q || !data->socket || !data->row || !data->file || !data->sockets ||
        !data->placements) {
        mukca_dataset_free(data);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", n_rows);
    }
    for (int i = 0; i < n_rows; i++) {
        data->row[i] = i + 1;
        data->socket[i] = -1;
    }
    return MUKCA_OK;
}

void mukca_dataset_free(mukca_dataset *data)
{
    void *const lists[] = {data->reading, data->socket,    data->row,   data->file,
                           data->target,  data->targets,   data->files, data->distances,
                           data->sockets, data->placements};
    for (int c = 0; c < MUKCA_COLUMNS; c++) free(data->column[c]);
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) free(lists[i]);
    memset(data, 0, sizeof *data);
}
