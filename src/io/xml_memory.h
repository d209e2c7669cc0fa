/* Detection of failed allocations in libxml2. */
#ifndef MUKCA_IO_XML_MEMORY_H
#define MUKCA_IO_XML_MEMORY_H

#include <stdbool.h>

/* Call before parsing a text. */
void mukca_xml_memory_watch(void);

/* Whether an allocation has failed since mukca_xml_memory_watch; the tree may then lack
 * elements. */
bool mukca_xml_memory_failed(void);

#endif
