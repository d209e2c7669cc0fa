/* Known distances between the sockets of a placement. */
#ifndef MUKCA_IO_DISTANCES_H
#define MUKCA_IO_DISTANCES_H

#include "io/dataset_build.h"

/* Any two sockets of a placement are `distance` (m) apart; refused for more than 4 sockets, which
 * no arrangement in space allows. */
mukca_status mukca_distances_set(mukca_dataset_builder *builder, double distance);

/* Distances from a table `socket_a socket_b distance_m`, for all placements that have both sockets;
 * every placement needs one. */
mukca_status mukca_distances_read(mukca_dataset_builder *builder, const char *path);

#endif
