/* A representative part of a long recording. */
#include "fit/part.h"

#include <stdlib.h>
#include <string.h>

#include "model/dataset_subset.h"

int mukca_part_mark(unsigned char *keep, const mukca_dataset *data, int most)
{
    int groups = 0, kept = 0;
    const size_t places = (size_t)data->n_placements + 1, sockets = (size_t)data->n_sockets + 1;
    int *rows = calloc(places + sockets, sizeof *rows);
    if (!rows) return -1;
    int *seen = rows + places; /* samples so far of the poses, then of each socket */
    for (int i = 0; i < data->n_rows; i++) rows[mukca_dataset_placement(data, i) + 1]++;
    for (size_t g = 0; g < places; g++) groups += rows[g] > 0;
    for (int i = 0; i < data->n_rows; i++) {
        const long long in_group = rows[mukca_dataset_placement(data, i) + 1];
        const int every = (int)((in_group * groups + most - 1) / most);
        keep[i] = seen[data->socket[i] + 1]++ % every == 0;
        kept += keep[i];
    }
    free(rows);
    return kept;
}

mukca_status mukca_part_take(mukca_dataset *part, const mukca_dataset *data, int most,
                             mukca_error *error)
{
    unsigned char *keep = malloc((size_t)data->n_rows + 1);
    const bool marked = keep && mukca_part_mark(keep, data, most) >= 0;
    const mukca_status status = marked ? mukca_dataset_subset(part, data, keep, error)
                                       : mukca_fail(error, MUKCA_MEMORY, "out of memory");
    free(keep);
    return status;
}
