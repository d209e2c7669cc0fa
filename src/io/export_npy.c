/* Joint zero offsets as a NumPy array, in the format of drake-franka-driver's joint_pos_offset.npy:
 * angle of the arm = angle of the controller + offset. */
#include <stdint.h>
#include <string.h>

#include "io/export.h"

/* Format 1.0 (numpy.lib.format): magic, version, length of the header, header, data.  The header
 * ends with a line feed; data begin at a multiple of 64 bytes. */
static mukca_status write_npy(FILE *stream, const mukca_export_input *input)
{
    enum { PREFIX = 10, ALIGNED = 128 };
    const int n = input->chain->n_joints;
    char header[ALIGNED - PREFIX + 1];
    const int used = snprintf(header, sizeof header,
                              "{'descr': '<f8', 'fortran_order': False, 'shape': (%d,), }", n);
    memset(header + used, ' ', sizeof header - (size_t)used);
    header[sizeof header - 2] = '\n';
    fwrite("\x93NUMPY\x01", 1, 7, stream);
    fputc(0, stream);
    fputc(ALIGNED - PREFIX, stream);
    fputc(0, stream);
    fwrite(header, 1, ALIGNED - PREFIX, stream);
    for (int j = 0; j < n; j++) {
        uint64_t bits;
        memcpy(&bits, &input->zeros[j], sizeof bits);
        for (int byte = 0; byte < 8; byte++) fputc((int)(bits >> (8 * byte) & 0xff), stream);
    }
    return MUKCA_OK;
}

const mukca_export_format mukca_export_npy = {.write = write_npy, .zeros_only = true};
