/* Joint states as lines: any bytes give joints, a trigger, nothing, or one clear fault. */
#include "memory_file.h"
#include "record/joint_lines.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_joint_lines lines;
    static mukca_lcm_joints joints;
    mukca_error error;
    const char *line;
    FILE *file = fopen(memory_file(bytes, size), "rb");
    if (!file) abort();
    mukca_joint_lines_open(&lines, fileno(file));
    for (;;) {
        line = mukca_joint_lines_peek(&lines);
        if (!line && lines.ended) break;
        if (!line) {
            mukca_joint_lines_fill(&lines);
            continue;
        }
        error.text[0] = '\0';
        switch (mukca_joint_lines_parse(&joints, &lines, line, &error)) {
            case MUKCA_LINE_JOINTS:
                if (joints.n < 1 || joints.n > MUKCA_LCM_MAX_JOINTS) abort();
                for (int j = 0; j < joints.n && joints.has[MUKCA_LCM_ROLE_NAME]; j++)
                    if (strlen(joints.name[j]) > size) abort();
                for (int j = 0; j < joints.n; j++)
                    for (int r = MUKCA_LCM_ROLE_POSITION; r < MUKCA_LCM_ROLES; r++)
                        if (isinf(joints.value[r][j])) abort();
                break;
            case MUKCA_LINE_TRIGGER:
                if (strlen(lines.trigger.placement) > size || strlen(lines.trigger.socket) > size)
                    abort();
                break;
            case MUKCA_LINE_FAULT:
                if (!error.text[0]) abort();
                break;
            case MUKCA_LINE_NONE:
                break;
        }
        mukca_joint_lines_take(&lines);
    }
    fclose(file);
    return 0;
}
