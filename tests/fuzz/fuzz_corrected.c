/* Tables for controllers: read or refused; what is read can be asked for positions and Jacobians.
 */
#include "arm/offsets.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_corrected model;
    mukca_error error = {MUKCA_OK, ""};
    double q[MUKCA_MAX_JOINTS], J[6 * MUKCA_MAX_JOINTS], position[3];
    mukca_frame tip;
    char *text = as_text(bytes, size);
    mukca_status status = mukca_corrected_parse_named(
        &model, text, strlen(text), "table", MUKCA_ACCEPT_FAILED | MUKCA_ACCEPT_EDITED, &error);
    check_refusal(status, &error);
    for (int j = 0; j < MUKCA_MAX_JOINTS; j++) q[j] = 0.3 * j - 1;
    if (status == MUKCA_OK) {
        mukca_corrected_position(position, &model, q, NULL);
        mukca_corrected_pose(&tip, &model, q, NULL);
        mukca_corrected_jacobian(J, NULL, &model, q, NULL);
    }
    free(text);
    return 0;
}
