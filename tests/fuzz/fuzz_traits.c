/* Traits tables: read to the end or to an error of one line; what was read can be written. */
#include "../unit/arms.h"
#include "io/summary.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    static mukca_traits traits;
    mukca_error error = {MUKCA_OK, ""};
    char *text = NULL;
    size_t length = 0;
    make_chain(&chain, "RR", NULL, "j", 3);
    const mukca_status status =
        mukca_traits_read(&traits, memory_file(bytes, size), &chain, &error);
    check_refusal(status, &error);
    if (status) return 0;
    FILE *stream = open_memstream(&text, &length);
    mukca_traits_write(stream, &traits);
    fclose(stream);
    free(text);
    return 0;
}
