/* A dataset that grows row by row. */
#include "io/dataset_build.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

void mukca_build_note(const mukca_dataset_builder *builder, const char *format, ...)
{
    if (!builder->note) return;
    char text[256];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    builder->note(builder->context, text);
}

static mukca_status out_of_memory(const mukca_dataset_builder *builder)
{
    return mukca_fail(builder->error, MUKCA_MEMORY, "out of memory while reading data");
}

/* The list with room for one item more, zeroed; NULL: out of memory, the old list stays. */
static void *grow(void *list, int count, size_t size)
{
    char *grown = realloc(list, ((size_t)count + 1) * size);
    if (grown) memset(grown + (size_t)count * size, 0, size);
    return grown;
}

mukca_status mukca_build_file(int *index, mukca_dataset_builder *builder, const char *path)
{
    mukca_dataset *d = builder->data;
    void *grown = grow(d->files, d->n_files, sizeof *d->files);
    if (!grown) return out_of_memory(builder);
    d->files = grown;
    snprintf(d->files[d->n_files], sizeof *d->files, "%s", path);
    *index = d->n_files++;
    return MUKCA_OK;
}

mukca_status mukca_build_placement(int *index, mukca_dataset_builder *builder, const char *name)
{
    mukca_dataset *d = builder->data;
    void *grown = grow(d->placements, d->n_placements, sizeof *d->placements);
    if (!grown) return out_of_memory(builder);
    d->placements = grown;
    snprintf(d->placements[d->n_placements].name, MUKCA_NAME_SIZE, "%s", name);
    *index = d->n_placements++;
    return MUKCA_OK;
}

mukca_status mukca_build_socket(int *index, mukca_dataset_builder *builder, int placement,
                                const char *label)
{
    mukca_dataset *d = builder->data;
    void *grown = grow(d->sockets, d->n_sockets, sizeof *d->sockets);
    if (!grown) return out_of_memory(builder);
    d->sockets = grown;
    d->sockets[d->n_sockets].placement = placement;
    snprintf(d->sockets[d->n_sockets].label, MUKCA_NAME_SIZE, "%s", label);
    *index = d->n_sockets++;
    return MUKCA_OK;
}

mukca_status mukca_build_distance(mukca_dataset_builder *builder, int a, int b, double distance)
{
    mukca_dataset *d = builder->data;
    void *grown = grow(d->distances, d->n_distances, sizeof *d->distances);
    if (!grown) return out_of_memory(builder);
    d->distances = grown;
    d->distances[d->n_distances++] = (mukca_distance){a, b, distance};
    return MUKCA_OK;
}

/* realloc of a list of rows; a new part of an optional list is NaN. */
static bool resize(double **list, int width, const mukca_dataset_builder *builder, int capacity)
{
    size_t w = (size_t)width;
    double *grown = realloc(*list, (size_t)capacity * w * sizeof **list);
    if (!grown) return false;
    size_t from = *list ? (size_t)builder->capacity * w : 0;
    for (size_t i = from; i < (size_t)capacity * w; i++) grown[i] = (double)NAN;
    *list = grown;
    return true;
}

static bool resize_ints(int **list, int capacity)
{
    int *grown = realloc(*list, (size_t)capacity * sizeof **list);
    if (grown) *list = grown;
    return grown != NULL;
}

static mukca_status reserve(mukca_dataset_builder *builder)
{
    mukca_dataset *d = builder->data;
    if (d->n_rows < builder->capacity) return MUKCA_OK;
    int capacity = builder->capacity ? 2 * builder->capacity : 128, n = d->n_joints;
    double **const lists[] = {&d->time,    &d->temperature, &d->payload,  &d->effort,
                              &d->command, &d->velocity,    &d->position, &d->quaternion};
    const int width[] = {1, 1, 1, n, n, n, 3, 4};
    if (capacity > 1 << 28 || !resize(&d->q, n, builder, capacity) ||
        !resize_ints(&d->socket, capacity) || !resize_ints(&d->row, capacity) ||
        !resize_ints(&d->file, capacity))
        return out_of_memory(builder);
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        if (*lists[i] && !resize(lists[i], width[i], builder, capacity))
            return out_of_memory(builder);
    builder->capacity = capacity;
    return MUKCA_OK;
}

/* Store values[width] in the row of an optional list, which is made where any of them is a number.
 */
static mukca_status set_optional(double **list, int width, mukca_dataset_builder *builder, int row,
                                 const double *values)
{
    bool any = false;
    for (int i = 0; i < width; i++) any |= !isnan(values[i]);
    if (!any) return MUKCA_OK;
    if (!*list && !resize(list, width, builder, builder->capacity)) return out_of_memory(builder);
    memcpy(*list + (size_t)row * (size_t)width, values, (size_t)width * sizeof *values);
    return MUKCA_OK;
}

mukca_status mukca_build_row(mukca_dataset_builder *builder, const mukca_row *row, int socket,
                             int file, int row_in_file)
{
    mukca_dataset *d = builder->data;
    const int n = d->n_joints;
    mukca_status status = reserve(builder);
    if (status) return status;
    const int i = d->n_rows++;
    memcpy(d->q + (size_t)i * (size_t)n, row->q, (size_t)n * sizeof *row->q);
    d->socket[i] = socket;
    d->file[i] = file;
    d->row[i] = row_in_file;
    const struct {
        double **list;
        int width;
        const double *values;
    } optional[] = {{&d->time, 1, &row->time},        {&d->temperature, 1, &row->temperature},
                    {&d->payload, 1, &row->payload},  {&d->effort, n, row->effort},
                    {&d->command, n, row->command},   {&d->velocity, n, row->velocity},
                    {&d->position, 3, row->position}, {&d->quaternion, 4, row->quaternion}};
    for (size_t k = 0; k < sizeof optional / sizeof *optional && status == MUKCA_OK; k++)
        status = set_optional(optional[k].list, optional[k].width, builder, i, optional[k].values);
    return status;
}

mukca_status mukca_build_pose(mukca_dataset_builder *builder, int row, const double pose[7])
{
    mukca_status status = set_optional(&builder->data->position, 3, builder, row, pose);
    if (status == MUKCA_OK)
        status = set_optional(&builder->data->quaternion, 4, builder, row, pose + 3);
    return status;
}
