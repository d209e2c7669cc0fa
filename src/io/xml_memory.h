/* libxml2's memory: whether an allocation has failed. */
#ifndef MUKCA_IO_XML_MEMORY_H
#define MUKCA_IO_XML_MEMORY_H

#include <stdbool.h>

/* Call before a text is parsed. */
void mukca_xml_memory_watch(void);

/* Whether an allocation has failed since then: the tree may lack elements, or not. */
bool mukca_xml_memory_failed(void);

#endif
