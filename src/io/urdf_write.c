/* A chain as a URDF. */
#include "io/urdf.h"

#include "io/export.h"

static void print_tag(FILE *stream, const char *start, const char *name, const char *end)
{
    fputs(start, stream);
    mukca_export_escaped(stream, name);
    fputs(end, stream);
}

static void print_numbers(FILE *stream, const char *start, const double x[3])
{
    fputs(start, stream);
    mukca_export_numbers(stream, x, 3, " ");
}

void mukca_urdf_write(FILE *stream, const mukca_chain *chain)
{
    print_tag(stream, "<?xml version=\"1.0\"?>\n<robot name=\"", chain->robot, "\">\n");
    print_tag(stream, "  <link name=\"", chain->base, "\"/>\n");
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *e = &chain->element[k];
        const bool limited = isfinite(e->lower) && isfinite(e->upper);
        const bool turns = mukca_joint_turns(e->type);
        const double limits[2] = {limited ? e->lower : -1, limited ? e->upper : 1};
        const mukca_joint_type turning = limited ? MUKCA_REVOLUTE : MUKCA_CONTINUOUS;
        const mukca_joint_type type = turns ? turning : e->type;
        print_tag(stream, "  <link name=\"", e->child, "\"/>\n");
        print_tag(stream, "  <joint name=\"", e->name, "\" type=\"");
        fprintf(stream, "%s\">\n", mukca_joint_type_name[type]);
        print_tag(stream, "    <parent link=\"", k ? chain->element[k - 1].child : chain->base,
                  "\"/>\n");
        print_tag(stream, "    <child link=\"", e->child, "\"/>\n");
        print_numbers(stream, "    <origin xyz=\"", e->xyz);
        print_numbers(stream, "\" rpy=\"", e->rpy);
        fputs("\"/>\n", stream);
        if (e->type != MUKCA_FIXED) {
            print_numbers(stream, "    <axis xyz=\"", e->axis);
            fputs("\"/>\n", stream);
        }
        if (type == MUKCA_REVOLUTE || type == MUKCA_PRISMATIC) {
            fputs("    <limit lower=\"", stream);
            mukca_export_numbers(stream, limits, 2, "\" upper=\"");
            fputs("\" effort=\"0\" velocity=\"0\"/>\n", stream);
        }
        fputs("  </joint>\n", stream);
    }
    fputs("</robot>\n", stream);
}
