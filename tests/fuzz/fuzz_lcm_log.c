/* Event logs: read to the end, every byte either of an event or counted as skipped. */
#include "lcm/link.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    mukca_lcm_log log;
    mukca_lcm_packet event;
    mukca_error error;
    if (mukca_lcm_log_open(&log, memory_file(bytes, size), &error)) return 0; /* no event */
    size_t used = 0;
    while (mukca_lcm_log_read(&event, &log)) {
        used += 28 + event.size;
        if (event.size && ((const unsigned char *)event.data)[event.size - 1] > 255) abort();
    }
    if (used + (size_t)log.skipped > size) abort();
    mukca_lcm_log_close(&log);
    return 0;
}
