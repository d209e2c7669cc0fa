/* Lines of an offsets table. */
#include "arm/offset_lines.h"

mukca_offset_row mukca_offset_row_parameter(const mukca_chain *chain, int index, double calibrated)
{
    const mukca_element *element = &chain->element[index / MUKCA_PARAMETERS];
    const int p = index % MUKCA_PARAMETERS;
    const double nominal = p < 3 ? element->xyz[p] : element->rpy[p - 3];
    return (mukca_offset_row){.joint = element->name,
                              .parameter = mukca_parameter_name[p],
                              .unit = p < 3 ? "m" : "rad",
                              .nominal = nominal,
                              .calibrated = calibrated,
                              .offset = calibrated - nominal,
                              .sigma = (double)NAN,
                              .identifiable = true,
                              .term = "-"};
}

/* Write a text without control characters, which would break the table. */
static void write_text(FILE *stream, const char *text)
{
    for (; *text; text++) fputc((unsigned char)*text < ' ' ? ' ' : *text, stream);
}

static void write_numbers(FILE *stream, const double *x, int n)
{
    for (int i = 0; i < n; i++) fprintf(stream, "%s%.17g", i ? " " : "\t", x[i]);
}

void mukca_offset_line(FILE *stream, const char *key, const char *text)
{
    fprintf(stream, "# %s", key);
    write_text(stream, text);
    fputc('\n', stream);
}

void mukca_offset_lines_chain(FILE *stream, const mukca_chain *chain)
{
    fputs("# gravity:", stream);
    write_numbers(stream, chain->gravity, 3);
    fputc('\n', stream);
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *e = &chain->element[k];
        const double limits[2] = {e->lower, e->upper};
        fputs("# element:\t", stream);
        write_text(stream, e->name);
        fputc('\t', stream);
        write_text(stream, e->child);
        fprintf(stream, "\t%s", mukca_joint_type_name[e->type]);
        write_numbers(stream, e->axis, 3);
        write_numbers(stream, e->xyz, 3);
        write_numbers(stream, e->rpy, 3);
        write_numbers(stream, limits, 2);
        fputc('\n', stream);
    }
    for (int m = 0; m < chain->n_masses; m++) {
        fprintf(stream, "# mass:\t%d", chain->mass[m].element);
        write_numbers(stream, &chain->mass[m].kg, 1);
        write_numbers(stream, chain->mass[m].com, 3);
        fputc('\n', stream);
    }
}

void mukca_offset_lines_names(FILE *stream, const mukca_chain *chain)
{
    mukca_offset_line(stream, "robot: ", chain->robot);
    mukca_offset_line(stream, "urdf_sha256: ", chain->urdf_sha256);
    if (chain->kinematics_sha256[0])
        mukca_offset_line(stream, "kinematics_sha256: ", chain->kinematics_sha256);
    if (chain->kinematics_hash[0])
        mukca_offset_line(stream, "kinematics_hash: ", chain->kinematics_hash);
    mukca_offset_line(stream, "base: ", chain->base);
    mukca_offset_line(stream, "tip: ", chain->tip);
}

void mukca_offset_lines_columns(FILE *stream)
{
    fputs(
        "# formula: calibrated = nominal + offset; T_parent_child(q) = [Rz(yaw) Ry(pitch) "
        "Rx(roll) R(axis, q), (x y z)] with the calibrated values in place of the URDF's origin\n",
        stream);
    fputs("joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm\n",
          stream);
}

void mukca_offset_lines_row(FILE *stream, const mukca_offset_row *row)
{
    fprintf(stream, "%s\t%s\t%s\t%.17g\t%.17g\t%.17g\t%.17g\t%d\t%s\n", row->joint, row->parameter,
            row->unit, row->nominal, row->calibrated, row->offset, row->sigma, row->identifiable,
            row->term);
}
