/* Lines of robot programs: any text; targets lie within it and can be printed again. */
#include <stdlib.h>
#include <string.h>

#include "io/language.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);
int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size)
{
    static mukca_chain chain;
    char *line = malloc(size + 1), *printed = NULL;
    size_t length;
    if (!line) return 0;
    memcpy(line, data, size);
    line[size] = '\0';
    for (int n = 3; n <= 8; n++) {
        chain.n_joints = n;
        for (int l = 0; l < 3; l++)
            for (int pose = 0; pose < 2; pose++) {
                mukca_program_reader reader = {
                    .language = mukca_languages[l], .chain = &chain, .pose = pose};
                mukca_program_target t;
                size_t at = 0;
                mukca_program_line(&reader, line);
                while (mukca_program_next(&t, &reader)) {
                    if (t.begin < at || t.end <= t.begin || t.end > strlen(line)) abort();
                    at = t.end;
                    FILE *stream = open_memstream(&printed, &length);
                    if (!stream) break;
                    if (pose && !t.incomplete)
                        mukca_language_replace_pose(stream, &reader, &t, &t.pose);
                    else if (!t.incomplete)
                        mukca_language_replace(stream, &reader, &t, t.q);
                    fclose(stream);
                    free(printed);
                }
            }
    }
    free(line);
    return 0;
}
