/* Detection of failed allocations in libxml2, which reports another error, or none. */
#include "io/xml_memory.h"

#include <libxml/xmlmemory.h>
#include <stdlib.h>
#include <string.h>

static bool failed; /* libxml2's functions have no context */

static void *watch(void *memory)
{
    failed |= !memory;
    return memory;
}

static void *allocate(size_t size)
{
    return watch(malloc(size));
}

static void *grow(void *memory, size_t size)
{
    return watch(realloc(memory, size));
}

static char *duplicate(const char *text)
{
    return watch(strdup(text));
}

void mukca_xml_memory_watch(void)
{
    failed = false;
    xmlMemSetup(free, allocate, grow, duplicate);
}

bool mukca_xml_memory_failed(void)
{
    return failed;
}
