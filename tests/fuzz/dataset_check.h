/* What holds of every dataset that was read. */
#ifndef MUKCA_FUZZ_DATASET_CHECK_H
#define MUKCA_FUZZ_DATASET_CHECK_H

#include <math.h>
#include <stdlib.h>

#include "model/dataset.h"

static inline void dataset_check(const mukca_dataset *data)
{
    for (int i = 0; i < data->n_rows; i++) {
        if (data->socket[i] < -1 || data->socket[i] >= data->n_sockets) abort();
        if (data->file[i] < 0 || data->file[i] >= data->n_files || data->row[i] < 1) abort();
        for (int j = 0; j < data->n_joints; j++)
            if (!isfinite(data->q[i * data->n_joints + j])) abort();
        double square = 0;
        for (int k = 0; k < 4 && data->quaternion; k++)
            square += data->quaternion[4 * i + k] * data->quaternion[4 * i + k];
        if (data->quaternion && fabs(square - 1) > 1e-9) abort(); /* NaN: none was measured */
    }
    for (int s = 0; s < data->n_sockets; s++)
        if (data->sockets[s].placement >= data->n_placements) abort();
    for (int k = 0; k < data->n_distances; k++)
        if (!(data->distances[k].distance > 0) || data->distances[k].a >= data->distances[k].b)
            abort();
}

#endif
