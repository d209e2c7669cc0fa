/* Sessions, pose logs, distances and inertials: read or refused; what is read is consistent. */
#include <math.h>
#include <string.h>

#include "io/dataset_load.h"
#include "io/inertials.h"
#include "memory_file.h"

static void check(const mukca_dataset *data)
{
    for (int i = 0; i < data->n_rows; i++) {
        if (data->socket[i] < -1 || data->socket[i] >= data->n_sockets) abort();
        if (data->file[i] < 0 || data->file[i] >= data->n_files || data->row[i] < 1) abort();
        for (int j = 0; j < data->n_joints; j++)
            if (!isfinite(data->q[i * data->n_joints + j])) abort();
    }
    for (int s = 0; s < data->n_sockets; s++)
        if (data->sockets[s].placement >= data->n_placements) abort();
    for (int k = 0; k < data->n_distances; k++)
        if (!(data->distances[k].distance > 0) || data->distances[k].a >= data->distances[k].b)
            abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    static const uint8_t session[] =
        "placement\tsocket\tj1\tj2\np\ta\t0\t0\np\tb\t0\t0\np\tc\t0\t0\n";
    mukca_dataset data;
    mukca_error error = {MUKCA_OK, ""};
    mukca_inertial *list;
    int n;
    chain.n_elements = chain.n_joints = 2;
    for (int j = 0; j < 2; j++) {
        snprintf(chain.element[j].name, sizeof chain.element[j].name, "j%d", j + 1);
        chain.element[j].type = MUKCA_REVOLUTE;
        chain.element[j].axis[2] = 1;
        chain.element[j].upper = 3;
        chain.joint_element[j] = j;
    }
    const char *path = memory_file(bytes, size), *fixed = memory_file(session, sizeof session - 1);
    mukca_dataset_options options = {.partial = size % 2 == 0};
    mukca_status status = mukca_dataset_load(&data, &chain, &path, 1, &options, &error);
    if (status && (!error.text[0] || strchr(error.text, '\n'))) abort();
    if (status == MUKCA_OK) check(&data);
    mukca_dataset_free(&data);
    options = (mukca_dataset_options){.distances = path, .partial = true};
    if (mukca_dataset_load(&data, &chain, &fixed, 1, &options, &error) == MUKCA_OK) check(&data);
    mukca_dataset_free(&data);
    if (mukca_inertials_read(&list, &n, path, &error) == MUKCA_OK) free(list);
    return 0;
}
