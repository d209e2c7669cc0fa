/* Text wrapped to the width of a terminal. */
#include <string.h>

#include "cli/cli.h"

void cli_print_words(FILE *stream, int indent, int column, const char *text, size_t length)
{
    const char *end = text + length;
    bool first = true;
    while (text < end) {
        while (text < end && *text == ' ') text++;
        size_t word = 0;
        while (text + word < end && text[word] != ' ') word++;
        if (!word) break;
        if (!first && column + 1 + (int)word > CLI_WIDTH) {
            fprintf(stream, "\n%*s", indent, "");
            column = indent;
            first = true;
        }
        column += fprintf(stream, "%s%.*s", first ? "" : " ", (int)word, text);
        first = false;
        text += word;
    }
    fputc('\n', stream);
}

void cli_print_wrapped(FILE *stream, int indent, const char *text)
{
    while (*text) {
        size_t length = strcspn(text, "\n");
        if (length == 0)
            fputc('\n', stream);
        else if (*text == ' ')
            fprintf(stream, "%*s%.*s\n", indent, "", (int)length, text);
        else {
            fprintf(stream, "%*s", indent, "");
            cli_print_words(stream, indent, indent, text, length);
        }
        text += length + (text[length] == '\n');
    }
}
