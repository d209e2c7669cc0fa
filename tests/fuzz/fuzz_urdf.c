/* URDFs: whatever loads can be exported with other origins, and loads again with just those. */
#include "io/export.h"
#include "io/urdf.h"
#include "memory_file.h"

/* urdfdom leaks the tree of a file that it refuses, where links point at each other in a circle. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:urdf::parseURDF";
}

/* What the patched text must hold: the same chain with the origins of `offsets`. */
static void check_export(const char *path, const mukca_chain *chain,
                         const mukca_urdf_options *options)
{
    static mukca_offsets offsets;
    static mukca_chain patched;
    char *text = NULL;
    size_t length = 0;
    mukca_offsets_init(&offsets, chain);
    for (int k = 0; k < chain->n_elements; k++)
        for (int p = 0; p < MUKCA_PARAMETERS; p++)
            if ((k + p) % 3) offsets.theta[MUKCA_PARAMETERS * k + p] = 0.125 * (k + 1) + p;
    const mukca_export_input input = {.urdf_path = path, .chain = chain, .offsets = &offsets};
    FILE *stream = open_memstream(&text, &length);
    mukca_status status = mukca_export_urdf.write(stream, &input);
    fclose(stream);
    if (status == MUKCA_OK) {
        const char *again = memory_file((const uint8_t *)text, length);
        if (mukca_urdf_load(&patched, again, options, NULL) != MUKCA_OK) abort();
        if (patched.n_elements != chain->n_elements) abort();
        for (int k = 0; k < chain->n_elements; k++)
            for (int i = 0; i < 3; i++) /* offsets below 1e-9 count as zero */
                if (!(fabs(patched.element[k].xyz[i] - offsets.theta[6 * k + i]) <= 1e-9) ||
                    !(fabs(patched.element[k].rpy[i] - offsets.theta[6 * k + 3 + i]) <= 1e-9))
                    abort();
    }
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    const char *path = memory_file(bytes, size);
    mukca_error error = {MUKCA_OK, ""};
    const mukca_urdf_options options = {.gravity = {0, 0, -9}};
    mukca_status status = mukca_urdf_load(&chain, path, &options, &error);
    check_refusal(status, &error);
    if (status == MUKCA_OK) check_export(path, &chain, &options);
    return 0;
}
