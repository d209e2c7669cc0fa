/* Inputs of the heart. */
#include "heart/read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROWS = 100000, MOST_HOLES = 16 };

static bool read_element(mukca_chain *chain, const char *line)
{
    char type[16];
    int kind = 0;
    mukca_element *e = &chain->element[chain->n_elements];
    double *a = e->axis, *p = e->xyz, *r = e->rpy;
    if (chain->n_elements == MUKCA_MAX_ELEMENTS ||
        sscanf(line,
               "# element: %63[^\t] %63[^\t] %15s %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf",
               e->name, e->child, type, &a[0], &a[1], &a[2], &p[0], &p[1], &p[2], &r[0], &r[1],
               &r[2], &e->lower, &e->upper) != 14)
        return false;
    while (kind < 4 && strcmp(mukca_joint_type_name[kind], type) != 0) kind++;
    if (kind == 4 || (kind != MUKCA_FIXED && chain->n_joints == MUKCA_MAX_JOINTS)) return false;
    e->type = (mukca_joint_type)kind;
    e->joint = kind == MUKCA_FIXED ? -1 : chain->n_joints++;
    if (e->joint >= 0) chain->joint_element[e->joint] = chain->n_elements;
    chain->n_elements++;
    return true;
}

mukca_status mukca_heart_arm(mukca_chain *chain, const char *path, mukca_error *error)
{
    char line[1024];
    FILE *file = fopen(path, "r");
    bool good = file != NULL;
    memset(chain, 0, sizeof *chain);
    while (good && fgets(line, sizeof line, file)) {
        if (strncmp(line, "# element:", 10) == 0) good = read_element(chain, line);
        sscanf(line, "# robot: %63[^\n]", chain->robot);
        sscanf(line, "# urdf_sha256: %64s", chain->urdf_sha256);
        sscanf(line, "# base: %63[^\n]", chain->base);
        sscanf(line, "# tip: %63[^\n]", chain->tip);
    }
    if (file) fclose(file);
    if (good && chain->n_joints > 0) return MUKCA_OK;
    return mukca_fail(error, MUKCA_INPUT, "%s: no arm; give an offsets table of mukca calibrate",
                      path);
}

static mukca_status read_socket(mukca_dataset *data, FILE *file, const char *path,
                                mukca_error *error)
{
    const int first = data->n_rows, n = data->n_joints;
    int j = 0;
    while (data->n_rows < MOST_ROWS &&
           fscanf(file, j ? ",%lf" : "%lf", &data->q[data->n_rows * n + j]) == 1)
        if (++j == n) data->socket[data->n_rows++] = data->n_sockets, j = 0;
    if (j > 0 || fscanf(file, " %*c") != EOF)
        return mukca_fail(error, MUKCA_INPUT, "%s:%d: not %d numbers, or too many lines", path,
                          data->n_rows - first + 1, n);
    data->sockets[data->n_sockets++].placement = data->n_placements;
    return MUKCA_OK;
}

mukca_status mukca_heart_data(mukca_dataset *data, const mukca_chain *chain, char *const *folder,
                              int n, mukca_error *error)
{
    char path[1024];
    FILE *file;
    MUKCA_TRY(mukca_dataset_create(data, MOST_ROWS, chain->n_joints, MOST_HOLES * n, n, error));
    data->distances = calloc(MOST_HOLES * MOST_HOLES * (size_t)n, sizeof *data->distances);
    if (!data->distances) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d folders", n);
    data->n_rows = data->n_sockets = data->n_placements = 0;
    for (; data->n_placements < n; data->n_placements++) {
        const int first = data->n_sockets;
        for (int hole = 0; hole < MOST_HOLES; hole++) {
            snprintf(path, sizeof path, "%s/hole_%d.csv", folder[data->n_placements], hole);
            if (!(file = fopen(path, "r"))) break;
            for (int s = first; s < data->n_sockets; s++)
                data->distances[data->n_distances++] =
                    (mukca_distance){s, data->n_sockets, MUKCA_DISTANCE, 0, 0};
            const mukca_status status = read_socket(data, file, path, error);
            fclose(file);
            MUKCA_TRY(status);
        }
        if (data->n_sockets == first)
            return mukca_fail(error, MUKCA_INPUT, "%s: cannot read", path);
    }
    return MUKCA_OK;
}
