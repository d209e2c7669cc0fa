/* Lines of robot programs: any text; the numbers of a target lie within it, in order. */
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
    for (int n = 3; n <= 8; n++)
        for (int l = 0; l < 3; l++) {
            const mukca_language *language = mukca_languages[l];
            mukca_program_target t;
            size_t at = 0;
            chain.n_joints = n;
            if (mukca_language_read(&t, language, &chain, line) != MUKCA_LINE_TARGET) continue;
            for (int j = 0; j < n; j++) {
                if (t.number[j][0] < at || t.number[j][1] <= t.number[j][0]) abort();
                at = t.number[j][1];
            }
            if (at > strlen(line)) abort();
            FILE *stream = open_memstream(&printed, &length);
            if (!stream) break;
            mukca_language_replace(stream, language, &chain, line, &t, t.q);
            fclose(stream);
            free(printed);
        }
    free(line);
    return 0;
}
