/* Parser of .lcm type descriptions: package, struct, const, comments; as lcm-gen accepts them. */
#ifndef MUKCA_LCM_DESCRIPTION_H
#define MUKCA_LCM_DESCRIPTION_H

#include "lcm/type.h"

/* Add the structs of one .lcm description, text[length], all or none; `file` is used in messages.
 * Errors: MUKCA_INPUT with file, line and column (syntax; enum; a nested type without description;
 * too many types or fields). */
mukca_status mukca_lcm_types_parse(mukca_lcm_types *types, const char *text, size_t length,
                                   const char *file, mukca_error *error);

/* The same from a file. */
mukca_status mukca_lcm_types_read(mukca_lcm_types *types, const char *path, mukca_error *error);

#endif
