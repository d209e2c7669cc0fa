/* Offsets tables: what is read can be written and read again without a change. */
#include "../unit/arms.h"
#include "io/offsets.h"
#include "memory_file.h"

static mukca_chain chain;

static void check_round(const mukca_offsets *offsets)
{
    static mukca_offsets again;
    mukca_error error;
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (mukca_offsets_write(stream, offsets, &chain, NULL, NULL, &error) != MUKCA_OK) abort();
    fclose(stream);
    const char *path = memory_file((const uint8_t *)text, length);
    const mukca_offsets_options options = {.accept = MUKCA_ACCEPT_FAILED};
    if (mukca_offsets_read(&again, &chain, path, &options, &error) != MUKCA_OK) abort();
    if (again.n_effects != offsets->n_effects ||
        again.acceptance.given != offsets->acceptance.given ||
        again.acceptance.accepted != offsets->acceptance.accepted ||
        memcmp(again.theta, offsets->theta, sizeof again.theta) != 0 ||
        memcmp(again.listed, offsets->listed, sizeof again.listed) != 0)
        abort();
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_offsets offsets;
    mukca_error error = {MUKCA_OK, ""};
    make_chain(&chain, "RR", NULL, "j", 3);
    memcpy(chain.urdf_sha256, "abc", 4);
    const char *path = memory_file(bytes, size);
    mukca_status status = mukca_offsets_read(
        &offsets, &chain, path,
        &(mukca_offsets_options){.accept = MUKCA_ACCEPT_FAILED | MUKCA_ACCEPT_EDITED}, &error);
    check_refusal(status, &error);
    if (status == MUKCA_OK) check_round(&offsets);
    return 0;
}
