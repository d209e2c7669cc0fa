/* Model files to be checked, as each format: compared with the table or refused in one line. */
#include <string.h>

#include "io/export.h"
#include "io/urdf.h"
#include "memory_file.h"

static const char urdf[] =
    "<robot name=\"r\"><link name=\"b\"/><link name=\"m\"/><link name=\"t\"/>"
    "<joint name=\"j1\" type=\"continuous\"><parent link=\"b\"/><child link=\"m\"/>"
    "<origin xyz=\"0 0 0.3\" rpy=\"0 0 0\"/><axis xyz=\"0 0 1\"/></joint>"
    "<joint name=\"j2\" type=\"fixed\"><parent link=\"m\"/><child link=\"t\"/>"
    "<origin xyz=\"0.1 0 0\"/></joint></robot>";

static void check(const mukca_exporter *exporter, const uint8_t *bytes, size_t size,
                  const mukca_export_input *input)
{
    mukca_export_difference d;
    mukca_error error = {MUKCA_OK, ""};
    const char *path = memory_file(bytes, size);
    if (mukca_export_check(&d, path, exporter, input, &error)) {
        if (!error.text[0] || strchr(error.text, '\n')) abort();
    } else if (d.compared < 0 || strchr(d.where, '\n') || (d.agrees && !(d.largest <= 1e-9))) {
        abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    static mukca_offsets offsets;
    mukca_error error;
    const char *path = memory_file((const uint8_t *)urdf, sizeof urdf - 1);
    if (!chain.n_joints) {
        if (mukca_urdf_load(&chain, path, NULL, NULL, NULL, &error)) abort();
        mukca_offsets_init(&offsets, &chain);
        offsets.theta[0] = 1e-3;
    }
    const mukca_export_input input = {.urdf_path = path, .chain = &chain, .offsets = &offsets};
    for (const mukca_exporter *e = mukca_exporters; e->name; e++) check(e, bytes, size, &input);
    return 0;
}
