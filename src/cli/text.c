/* Text for the terminal: wrapped, keyed, bold. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/cli.h"

enum { KEY = 8 };

static bool fancy(FILE *stream)
{
    const char *no = getenv("NO_COLOR"), *term = getenv("TERM");
    if (no && *no) return false;
    return isatty(fileno(stream)) && term && strcmp(term, "dumb") != 0;
}

const char *cli_bold(FILE *stream)
{
    return fancy(stream) ? "\033[1m" : "";
}

const char *cli_plain(FILE *stream)
{
    return fancy(stream) ? "\033[0m" : "";
}

/* Length of the first word, with the unit or other short word that follows a number. */
static size_t find_word(const char *text, const char *end)
{
    size_t word = 0, unit = 1;
    while (text + word < end && text[word] != ' ') word++;
    if (!word || !strchr("0123456789", text[word - 1])) return word;
    while (text + word + unit < end && text[word + unit] != ' ') unit++;
    return text + word < end && unit < 7 ? word + unit : word;
}

void cli_print_words(FILE *stream, int indent, int column, const char *text, size_t length)
{
    const char *end = text + length;
    bool first = true;
    while (text < end) {
        while (text < end && *text == ' ') text++;
        const size_t word = find_word(text, end);
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

void cli_print_wrapped(FILE *stream, const char *text)
{
    while (*text) {
        size_t length = strcspn(text, "\n");
        if (length == 0)
            fputc('\n', stream);
        else if (*text == ' ')
            fprintf(stream, "%.*s\n", (int)length, text);
        else
            cli_print_words(stream, 0, 0, text, length);
        text += length + (text[length] == '\n');
    }
}

void cli_print_keyed(FILE *stream, const char *key, const char *text)
{
    if (!key) {
        cli_print_wrapped(stream, text);
        return;
    }
    fprintf(stream, "%s%-*s%s", cli_bold(stream), KEY, key, cli_plain(stream));
    cli_print_words(stream, KEY, KEY, text, strlen(text));
}

void cli_print_text(FILE *stream, const char *key, mukca_text *text)
{
    if (text->used) cli_print_keyed(stream, key, text->at);
    text->at[text->used = 0] = '\0';
}

void cli_print_acceptance(FILE *stream, const mukca_acceptance *a, const mukca_chain *chain)
{
    char line[MUKCA_ACCEPTANCE_SENTENCE] = "";
    mukca_text text = MUKCA_TEXT(line);
    const bool factory = chain->kinematics_sha256[0] != '\0';
    if (!stream) return;
    if (a->accepted) mukca_acceptance_put_tip(&text, a, factory);
    cli_print_text(stream, "Tip", &text);
    mukca_acceptance_put_use(&text, a, factory);
    cli_print_text(stream, "Use", &text);
}

void cli_print_more(FILE *stream, int n)
{
    char line[80];
    snprintf(line, sizeof line, "and %d more; --json lists them all", n);
    cli_print_keyed(stream, "", line);
}
