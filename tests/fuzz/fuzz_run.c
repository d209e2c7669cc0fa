/* Runs of a moving arm, and drives of a model: read to the end or to an error of one line; times
 * rise, numbers are finite. */
#include "../unit/arms.h"
#include "io/drives.h"
#include "memory_file.h"
#include "record/joint_lines.h"

static void check(const mukca_run *run, const mukca_chain *chain)
{
    for (int i = 0; i < run->n; i++) {
        if (i > 0 && !(run->time[i] > run->time[i - 1])) abort();
        for (int j = 0; j < chain->n_joints; j++)
            if (!isfinite(run->q[i * chain->n_joints + j])) abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    mukca_run_options options = {0};
    mukca_drives drives;
    mukca_run run = {.name = "fuzz"};
    mukca_pool pool = {0};
    mukca_error error[2] = {{MUKCA_OK, ""}, {MUKCA_OK, ""}};
    const char *path = memory_file(bytes, size);
    make_chain(&chain, "RR", NULL, "j", 3);
    mukca_status status[2] = {mukca_run_load(&run, &pool, path, &chain, &options, &error[0])};
    if (status[0] == MUKCA_OK) check(&run, &chain);
    status[1] = mukca_drives_read(&drives, path, &chain, &error[1]);
    for (int k = 0; k < 2; k++) check_refusal(status[k], &error[k]);
    mukca_pool_free(&pool);
    return 0;
}
