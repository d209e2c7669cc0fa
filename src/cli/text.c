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
    if (key && *text) fprintf(stream, "%s%-*s%s", cli_bold(stream), KEY, key, cli_plain(stream));
    if (key && *text)
        cli_print_words(stream, KEY, KEY, text, strlen(text));
    else
        cli_print_wrapped(stream, text);
}

void cli_describe_data(char text[80], const mukca_dataset *data)
{
    mukca_text to = {.at = text, .size = 80};
    text[0] = '\0';
    mukca_text_put(&to, "%d %s%s", data->n_rows, data->n_sockets ? "sample" : "measured pose",
                   data->n_rows == 1 ? "" : "s");
    if (data->n_placements)
        mukca_text_put(&to, ", %d placement%s", data->n_placements,
                       data->n_placements == 1 ? "" : "s");
}

void cli_print_head(FILE *stream, const char *robot, const mukca_dataset *data,
                    const mukca_dataset *test)
{
    char texts[2][80] = {""};
    const bool tested = test && test->n_rows > 0;
    if (!stream) return;
    cli_describe_data(texts[0], data);
    if (tested) cli_describe_data(texts[1], test);
    fprintf(stream, "%s: %s%s%s\n", robot, texts[0], tested ? "; test: " : "", texts[1]);
}

void cli_print_acceptance(FILE *stream, const mukca_acceptance *a, const mukca_chain *chain)
{
    char tip[MUKCA_ACCEPTANCE_SENTENCE] = "", use[MUKCA_ACCEPTANCE_SENTENCE] = "";
    const bool factory = chain->kinematics_sha256[0] != '\0';
    if (!stream) return;
    if (a->accepted) mukca_acceptance_put_tip(&(mukca_text)MUKCA_TEXT(tip), a, factory);
    mukca_acceptance_put_use(&(mukca_text)MUKCA_TEXT(use), a, factory);
    cli_print_keyed(stream, "Use", use);
    cli_print_keyed(stream, "Tip", tip);
}
