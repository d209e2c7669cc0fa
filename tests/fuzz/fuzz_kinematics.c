/* Factory files: read or refused in one line, and then applied to an arm or refused in one line. */
#include "../unit/arms.h"
#include "io/kinematics.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_kinematics kinematics;
    static mukca_chain chain;
    mukca_error error = {MUKCA_OK, ""};
    const char *path = memory_file(bytes, size);
    make_chain(&chain, "RR", NULL, "arm_joint", 3);
    for (int k = 0; k < 2; k++)
        snprintf(chain.element[k].child, sizeof chain.element[k].child,
                 k ? "upper_arm_link" : "shoulder_link");
    mukca_status status = mukca_kinematics_read(&kinematics, path, &error);
    if (status == MUKCA_OK && kinematics.n < 1) abort();
    if (status == MUKCA_OK)
        status = mukca_kinematics_apply(&chain, &kinematics, path, (mukca_notes){0}, &error);
    check_refusal(status, &error);
    for (int i = 0; i < kinematics.n && status == MUKCA_OK; i++)
        for (int p = 0; p < MUKCA_PARAMETERS; p++)
            if (!(kinematics.entry[i].value[p] <= 1e6)) abort();
    return 0;
}
