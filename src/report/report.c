/* The page of the report: opening, and sections in reading order. */
#include "report/report.h"

#include "report/parts.h"

static const mukca_page_section sections[] = {
    {"causes", "Errors and their causes", NULL, mukca_report_put_causes},
    {"view", "The arm", NULL, mukca_report_put_view},
    {"placements", "Errors of the result", NULL, mukca_report_put_placements},
    {"joints", "Errors by joint", mukca_report_joints, mukca_report_put_joints},
    {"limits", "Detection limits", NULL, mukca_report_put_limits},
    {"samples", "Samples and recording faults", mukca_report_samples, mukca_report_put_faults},
    {"offsets", "Parameters", NULL, mukca_report_put_offsets},
    {"provenance", "Provenance", NULL, mukca_report_put_provenance},
};

static void open_page(FILE *out, const void *content)
{
    mukca_report_put_accuracy(out, content);
    mukca_report_put_verdict(out, content);
}

mukca_page mukca_report_page(const mukca_report *r)
{
    return (mukca_page){.robot = r->chain->robot,
                        .kind = "calibration report",
                        .from = r->free_base ? "the tracker's frame" : r->chain->base,
                        .to = r->free_tool ? "the target" : r->chain->tip,
                        .when = r->when,
                        .open = open_page,
                        .sections = sections,
                        .n_sections = sizeof sections / sizeof *sections,
                        .content = r};
}
