/* A dataset that grows row by row. */
#include "io/dataset_build.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"

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

/* The list with a zeroed item appended; NULL: out of memory, the old list stays. */
static void *append(void *list, int count, size_t size)
{
    char *grown = realloc(list, ((size_t)count + 1) * size);
    if (grown) memset(grown + (size_t)count * size, 0, size);
    return grown;
}

mukca_status mukca_build_file(int *index, mukca_dataset_builder *builder, const char *path)
{
    mukca_dataset *d = builder->data;
    void *grown = append(d->files, d->n_files, sizeof *d->files);
    if (!grown) return out_of_memory(builder);
    d->files = grown;
    snprintf(d->files[d->n_files], sizeof *d->files, "%s", path);
    *index = d->n_files++;
    return MUKCA_OK;
}

static bool has_placement(const mukca_dataset *d, const char *name)
{
    for (int p = 0; p < d->n_placements; p++)
        if (strcmp(d->placements[p].name, name) == 0) return true;
    return false;
}

mukca_status mukca_build_placement(int *index, mukca_dataset_builder *builder, const char *wanted,
                                   const char *qualified)
{
    mukca_dataset *d = builder->data;
    char name[MUKCA_NAME_SIZE];
    snprintf(name, sizeof name, "%s", has_placement(d, wanted) ? qualified : wanted);
    for (int k = 2; has_placement(d, name); k++)
        snprintf(name, sizeof name, "%.*s#%d", (int)mukca_utf8_fit(wanted, 50), wanted, k);
    if (strcmp(name, wanted) != 0)
        mukca_build_note(builder, "placement '%s' exists already; this one is called '%s'", wanted,
                         name);
    void *grown = append(d->placements, d->n_placements, sizeof *d->placements);
    if (!grown) return out_of_memory(builder);
    d->placements = grown;
    memcpy(d->placements[d->n_placements].name, name, sizeof name);
    *index = d->n_placements++;
    return MUKCA_OK;
}

mukca_status mukca_build_socket(int *index, mukca_dataset_builder *builder, int placement,
                                const char *label)
{
    mukca_dataset *d = builder->data;
    void *grown = append(d->sockets, d->n_sockets, sizeof *d->sockets);
    if (!grown) return out_of_memory(builder);
    d->sockets = grown;
    mukca_socket *socket = &d->sockets[d->n_sockets];
    socket->placement = placement;
    snprintf(socket->label, sizeof socket->label, "%s", label);
    *index = d->n_sockets++;
    return MUKCA_OK;
}

mukca_status mukca_build_distance(mukca_dataset_builder *builder, int a, int b, double metres)
{
    mukca_dataset *d = builder->data;
    void *grown = append(d->distances, d->n_distances, sizeof *d->distances);
    if (!grown) return out_of_memory(builder);
    d->distances = grown;
    d->distances[d->n_distances++] = (mukca_distance){.a = a, .b = b, .distance = metres};
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

/* An optional list of the dataset, and a row's values for it. */
typedef struct {
    double **list;
    int width;
    const double *values;
} column;

enum { OPTIONAL = 8 };

static void list_optional(column columns[OPTIONAL], mukca_dataset *d, const mukca_row *row)
{
    const int n = d->n_joints;
    const column all[OPTIONAL] = {
        {&d->time, 1, &row->time},        {&d->temperature, 1, &row->temperature},
        {&d->payload, 1, &row->payload},  {&d->effort, n, row->effort},
        {&d->command, n, row->command},   {&d->velocity, n, row->velocity},
        {&d->position, 3, row->position}, {&d->quaternion, 4, row->quaternion}};
    memcpy(columns, all, sizeof all);
}

/* Room for one row more. */
static mukca_status reserve(mukca_dataset_builder *builder, const column optional[OPTIONAL])
{
    enum { FIRST = 128, MOST = 1 << 28 }; /* rows; indices are int */
    mukca_dataset *d = builder->data;
    if (d->n_rows < builder->capacity) return MUKCA_OK;
    const int capacity = builder->capacity ? 2 * builder->capacity : FIRST;
    bool good = capacity <= MOST && resize(&d->q, d->n_joints, builder, capacity) &&
                resize_ints(&d->socket, capacity) && resize_ints(&d->row, capacity) &&
                resize_ints(&d->file, capacity);
    for (int i = 0; i < OPTIONAL && good; i++)
        if (*optional[i].list)
            good = resize(optional[i].list, optional[i].width, builder, capacity);
    if (!good) return out_of_memory(builder);
    builder->capacity = capacity;
    return MUKCA_OK;
}

/* Store the row's values, unless all are NaN; the list is made by the first row that has some. */
static mukca_status set_optional(const column *c, mukca_dataset_builder *builder, int row)
{
    bool any = false;
    for (int i = 0; i < c->width; i++) any |= !isnan(c->values[i]);
    if (!any) return MUKCA_OK;
    if (!*c->list && !resize(c->list, c->width, builder, builder->capacity))
        return out_of_memory(builder);
    memcpy(*c->list + (size_t)row * (size_t)c->width, c->values,
           (size_t)c->width * sizeof *c->values);
    return MUKCA_OK;
}

mukca_status mukca_build_row(mukca_dataset_builder *builder, const mukca_row *row, int socket,
                             int file, int row_in_file)
{
    mukca_dataset *d = builder->data;
    const size_t n = (size_t)d->n_joints;
    column optional[OPTIONAL];
    list_optional(optional, d, row);
    mukca_status status = reserve(builder, optional);
    if (status != MUKCA_OK) return status;
    const int i = d->n_rows++;
    memcpy(d->q + (size_t)i * n, row->q, n * sizeof *row->q);
    d->socket[i] = socket;
    d->file[i] = file;
    d->row[i] = row_in_file;
    for (int k = 0; k < OPTIONAL && status == MUKCA_OK; k++)
        status = set_optional(&optional[k], builder, i);
    return status;
}

mukca_status mukca_build_pose(mukca_dataset_builder *builder, int row, const double pose[7])
{
    mukca_dataset *d = builder->data;
    const column position = {&d->position, 3, pose}, quaternion = {&d->quaternion, 4, pose + 3};
    const mukca_status status = set_optional(&position, builder, row);
    return status == MUKCA_OK ? set_optional(&quaternion, builder, row) : status;
}
