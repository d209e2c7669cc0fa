/* The corrected arm from a file. */
#include <stdlib.h>
#include <string.h>

#include "arm/offsets.h"
#include "base/file.h"
#include "mukca/corrected.h"

mukca_status mukca_corrected_load_any(mukca_corrected *model, const char *path, int accept,
                                      mukca_error *error)
{
    char *text;
    mukca_status status = mukca_file_read(&text, path, error);
    if (status != MUKCA_OK) return status;
    status = mukca_corrected_parse_named(model, (mukca_bytes){text, strlen(text)},
                                         mukca_file_shown(path), accept, error);
    free(text);
    return status;
}

mukca_status mukca_corrected_load(mukca_corrected *model, const char *path, mukca_error *error)
{
    return mukca_corrected_load_any(model, path, 0, error);
}
