/* Summaries: read to the end or to an error of one line; what was read can be pooled and written.
 */
#include <string.h>

#include "fleet/traits.h"
#include "io/summary.h"
#include "memory_file.h"

static mukca_status take(void *context, const mukca_summary *summary, mukca_error *error)
{
    mukca_fleet *fleet = context;
    return fleet->n_sessions < 8 ? mukca_fleet_take(fleet, summary, "fuzz", error) : MUKCA_OK;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    mukca_error error = {MUKCA_OK, ""};
    mukca_fleet fleet = {0};
    mukca_fleet_result result = {0};
    mukca_status status = mukca_summary_read(memory_file(bytes, size), take, &fleet, &error);
    if (status == MUKCA_OK) status = mukca_fleet_gather(&fleet, &error);
    if (status == MUKCA_OK) status = mukca_fleet_pool(&result, &fleet, &error);
    if (status && (!error.text[0] || strchr(error.text, '\n'))) abort();
    mukca_fleet_result_free(&result);
    mukca_fleet_free(&fleet);
    return 0;
}
