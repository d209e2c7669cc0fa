/* Sessions, pose logs and distances: read or refused; what is read is consistent. */
#include "../unit/arms.h"
#include "dataset_check.h"
#include "io/dataset.h"
#include "memory_file.h"

/* The form of the orientations, by the length of the input. */
static mukca_rows_format format_of(size_t size)
{
    static const char *const forms[] = {"XYZ",  "zyz",     "vector", "wxyz",
                                        "xyzw", "inverse", "none",   "xyz=ZXZ"};
    mukca_rows_format format = {.inverse = size / 16 % 4 == 3};
    if (size % 16 < 8 && !mukca_rotation_form_read(&format.rotation, forms[size % 16])) abort();
    return format;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    static const uint8_t session[] =
        "placement\tsocket\tj1\tj2\np\ta\t0\t0\np\tb\t0\t0\np\tc\t0\t0\n";
    mukca_dataset data;
    mukca_error error = {MUKCA_OK, ""};
    const char *path = memory_file(bytes, size), *fixed = memory_file(session, sizeof session - 1);
    make_chain(&chain, "RR", NULL, "j", 3);
    mukca_dataset_options options = {.partial = size % 2 == 0, .format = format_of(size)};
    mukca_status status = mukca_dataset_load(&data, &chain, &path, 1, &options, &error);
    check_refusal(status, &error);
    if (status == MUKCA_OK) dataset_check(&data);
    mukca_dataset_free(&data);
    options = (mukca_dataset_options){.distances = path, .partial = true};
    if (mukca_dataset_load(&data, &chain, &fixed, 1, &options, &error) == MUKCA_OK)
        dataset_check(&data);
    mukca_dataset_free(&data);
    return 0;
}
