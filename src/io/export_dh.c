/* The calibrated arm as a Denavit-Hartenberg table, standard or modified. */
#include "io/export.h"
#include "model/dh.h"

static const char *const title[][2] = {{"standard", "Rz(theta + q) Tz(d) Tx(a) Rx(alpha)"},
                                       {"modified", "Rx(alpha) Tx(a) Rz(theta + q) Tz(d)"}};

static mukca_status write_table(FILE *stream, const mukca_export_input *input,
                                mukca_dh_convention convention)
{
    mukca_dh dh;
    double theta[MUKCA_MAX_THETA];
    for (int k = 0; k < input->chain->n_elements; k++) {
        mukca_export_origin origin;
        mukca_export_get_origin(&origin, input, k);
        for (int i = 0; i < 3; i++) {
            theta[MUKCA_PARAMETERS * k + i] = origin.xyz[i];
            theta[MUKCA_PARAMETERS * k + 3 + i] = origin.rpy[i];
        }
    }
    mukca_dh_from_chain(&dh, input->chain, theta, convention);
    mukca_export_provenance(stream, "# ", input);
    fprintf(stream,
            "# convention: %s\n# T_base_tip is the product of the rows' %s;\n"
            "# a prismatic joint adds q to d.\n"
            "joint\ttype\ta_m\talpha_rad\td_m\ttheta_rad\tlower\tupper\n",
            title[convention][0], title[convention][1]);
    for (int k = 0; k < dh.n_rows; k++) {
        const mukca_dh_row *r = &dh.row[k];
        const double values[] = {r->a, r->alpha, r->d, r->theta, r->lower, r->upper};
        fprintf(stream, "%s\t%s", r->name, mukca_joint_type_name[r->type]);
        for (int i = 0; i < 6; i++)
            mukca_export_print(stream, isfinite(values[i]) ? "\t$n" : "\t", values[i]);
        fputc('\n', stream);
    }
    return MUKCA_OK;
}

static mukca_status write_standard(FILE *stream, const mukca_export_input *input,
                                   mukca_error *error)
{
    (void)error;
    return write_table(stream, input, MUKCA_DH_STANDARD);
}

static mukca_status write_modified(FILE *stream, const mukca_export_input *input,
                                   mukca_error *error)
{
    (void)error;
    return write_table(stream, input, MUKCA_DH_MODIFIED);
}

const mukca_export_format mukca_export_dh = {
    .write = write_standard, .holds = mukca_export_holds_none, .comment = {"#", "\n"}};
const mukca_export_format mukca_export_mdh = {
    .write = write_modified, .holds = mukca_export_holds_none, .comment = {"#", "\n"}};
