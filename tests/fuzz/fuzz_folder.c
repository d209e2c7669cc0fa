/* Folders with the recordings of a placement: read or refused; what is read is consistent.  A line
 * =NAME begins the file hole_NAME.csv: 0, 1, 2, 0_pose or 1_pose. */
#include "../unit/arms.h"
#include "dataset_check.h"
#include "io/dataset.h"
#include "memory_folder.h"

/* The size of what lies before the next line =NAME. */
static size_t section(const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i + 1 < size; i++)
        if (bytes[i] == '\n' && bytes[i + 1] == '=') return i + 1;
    return size;
}

static void write_files(const uint8_t *bytes, size_t size)
{
    static const char *const names[] = {"0", "1", "2", "0_pose", "1_pose"};
    while (size) {
        const size_t length = section(bytes, size);
        const uint8_t *end = memchr(bytes, '\n', length);
        for (size_t i = 0; end && i < sizeof names / sizeof *names; i++) {
            char name[32];
            const size_t n = strlen(names[i]);
            if ((size_t)(end - bytes) != n + 1 || memcmp(bytes + 1, names[i], n) != 0) continue;
            snprintf(name, sizeof name, "hole_%s.csv", names[i]);
            memory_folder_write(name, end + 1, length - n - 2);
        }
        bytes += length;
        size -= length;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    mukca_dataset data;
    mukca_error error = {MUKCA_OK, ""};
    const char *folder = memory_folder();
    write_files(bytes, size);
    const mukca_dataset_options options = {.partial = size % 2 == 0};
    make_chain(&chain, "RR", NULL, "j", 3);
    mukca_status status = mukca_dataset_load(&data, &chain, &folder, 1, &options, &error);
    check_refusal(status, &error);
    if (status == MUKCA_OK) {
        dataset_check(&data);
        if (data.n_placements != 1 || data.n_sockets < 2 || data.n_files < data.n_sockets) abort();
    }
    mukca_dataset_free(&data);
    return 0;
}
