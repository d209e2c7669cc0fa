/* Does an exported model still agree with the table that it came from? */
#ifndef MUKCA_IO_EXPORT_CHECK_H
#define MUKCA_IO_EXPORT_CHECK_H

#include "io/export.h"

typedef struct {
    int compared;           /* numbers */
    double position, angle; /* largest differences, m and rad */
    bool agrees;
    char where[160]; /* the worst place, or what is missing */
} mukca_export_difference;

/* Compare the file `path` of that exporter with what the input would be written as now.  A URDF is
 * loaded and its origins are compared; a MuJoCo model may have more in it, its bodies are found by
 * their names; YAML and C must have the same numbers in the same order.
 * Errors: MUKCA_INPUT (cannot be read), MUKCA_MEMORY. */
mukca_status mukca_export_check(mukca_export_difference *difference, const char *path,
                                const mukca_exporter *exporter, const mukca_export_input *input,
                                mukca_error *error);

#endif
