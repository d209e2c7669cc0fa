/* The version of the library. */
#include "mukca/version.h"

const char *mukca_version(void)
{
    return MUKCA_VERSION;
}
