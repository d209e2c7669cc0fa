/* Summaries: read to the end or to an error of one line; what was read can be pooled and written.
 */
#include "fleet/fleet.h"
#include "io/summary.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    mukca_error error = {MUKCA_OK, ""};
    mukca_fleet fleet = {0};
    mukca_status status = mukca_summary_read(&fleet, memory_file(bytes, size), &error);
    if (status == MUKCA_OK) status = mukca_fleet_gather(&fleet, &error);
    if (status == MUKCA_OK) status = mukca_fleet_pool(&fleet, &error);
    check_refusal(status, &error);
    mukca_fleet_free(&fleet);
    return 0;
}
