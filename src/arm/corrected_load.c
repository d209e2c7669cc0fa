/* The corrected arm from a file. */
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "mukca/corrected.h"

mukca_status mukca_corrected_load_any(mukca_corrected *model, const char *path, bool accept_failed,
                                      mukca_error *error)
{
    char *text;
    mukca_status status = mukca_file_read(&text, path, error);
    if (status != MUKCA_OK) return status;
    mukca_error said = {0};
    static const char unnamed[] = "offsets table"; /* what the parser calls a table in memory */
    status = mukca_corrected_parse_any(model, text, strlen(text), accept_failed, &said);
    free(text);
    if (status == MUKCA_OK) return status;
    const bool begins = strncmp(said.text, unnamed, strlen(unnamed)) == 0;
    return mukca_fail(error, status, "%s%s", begins ? mukca_file_shown(path) : "",
                      said.text + (begins ? strlen(unnamed) : 0));
}

mukca_status mukca_corrected_load(mukca_corrected *model, const char *path, mukca_error *error)
{
    return mukca_corrected_load_any(model, path, false, error);
}
