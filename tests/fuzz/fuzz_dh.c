/* Denavit-Hartenberg tables: read or refused in one line; what was read makes a URDF. */
#include <string.h>

#include "io/urdf.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_dh dh;
    static mukca_chain chain;
    mukca_error error = {MUKCA_OK, ""};
    bool stated;
    char *text = NULL;
    size_t length;
    if (mukca_dh_read(&dh, &stated, memory_file(bytes, size), NULL, &error) != MUKCA_OK) {
        if (!error.text[0] || strchr(error.text, '\n')) abort();
        return 0;
    }
    mukca_dh_to_chain(&chain, &dh);
    if (chain.n_joints < 1 || chain.n_elements > MUKCA_MAX_ELEMENTS) abort();
    FILE *stream = open_memstream(&text, &length);
    if (!stream) abort();
    mukca_urdf_write(stream, &chain);
    fclose(stream);
    free(text);
    return 0;
}
