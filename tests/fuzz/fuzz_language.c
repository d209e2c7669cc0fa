/* Lines of robot programs: any text; the numbers of a target lie within it, in order. */
#include "io/language.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    char *line = as_text(bytes, size), *printed = NULL;
    size_t length;
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
