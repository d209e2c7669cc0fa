/* Recipes: joint angles of published experiments. */
#ifndef MUKCA_SIMULATE_RECIPE_H
#define MUKCA_SIMULATE_RECIPE_H

#include "mukca/chain.h"

/* name, rows, description.  After Kana et al., Sensors 2022, 22, 2295. */
#define MUKCA_RECIPE_LIST(X)                                                                      \
    X(SWEEPS, "sweeps", 1940,                                                                     \
      "one joint at a time, the others at zero; odd joints 0 to pi to -pi, even ones half of it") \
    X(RASTER, "raster", 165, "a raster over the first two quadrants of the base, tool downwards") \
    X(TARGETED, "targeted", 58, "points of a small work volume, tool downwards")                  \
    X(TARGETED_TEST, "targeted-test", 20, "other points of the same volume")

typedef enum {
#define MUKCA_RECIPE_ENUM(kind, name, rows, sentence) MUKCA_RECIPE_##kind,
    MUKCA_RECIPE_LIST(MUKCA_RECIPE_ENUM)
#undef MUKCA_RECIPE_ENUM
        MUKCA_RECIPE_COUNT
} mukca_recipe_kind;

typedef struct {
    const char *name;
    int rows;
    const char *sentence;
} mukca_recipe_info;

extern const mukca_recipe_info mukca_recipe_table[MUKCA_RECIPE_COUNT];

/* Fill q[rows][n_joints] of a recipe for an arm with its nominal geometry, within the joint limits.
 * Errors: MUKCA_INPUT (a point is out of reach). */
mukca_status mukca_recipe_rows(double *q, mukca_recipe_kind kind, const mukca_chain *chain,
                               mukca_error *error);

#endif
