/* Shell completion, the man page and a plain list of options, all from the tables. */
#include <string.h>

#include "cli/cli.h"
#include "record/server.h"

/* Cases of the script for values from a list of words. */
static void print_bash_values(const cli_command *c, const cli_option *o)
{
    const bool effect = o->argument && strncmp(o->argument, "EFFECT", 6) == 0;
    if (o->kind != CLI_CHOICE && !effect) return;
    printf("            %s:--%s", c->name, o->name);
    if (o->letter) printf("|%s:-%c", c->name, o->letter);
    printf(") files= words=\"");
    for (int kind = 0; effect && kind < MUKCA_EFFECT_COUNT; kind++)
        printf("%s%s", kind ? " " : "", mukca_effect_table[kind]->name);
    for (int i = 0; !effect && o->choices[i]; i++) printf("%s%s", i ? " " : "", o->choices[i]);
    puts("\" ;;");
}

static void print_bash(void)
{
    puts(
        "# bash completion for mukca\n_mukca() {\n"
        "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
        "    local words= files=yes\n"
        "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
        "        files= words=\"help completion --version\"");
    for (const cli_command *const *c = cli_commands; *c; c++)
        printf("        words+=\" %s\"\n", (*c)->name);
    printf(
        "    elif [ \"$COMP_CWORD:${COMP_WORDS[1]}\" = 2:send ] && [[ $word != -* ]]; then\n"
        "        files= words=\"status");
    for (int i = 0; mukca_server_verbs[i]; i++) printf(" %s", mukca_server_verbs[i]);
    puts("\"\n    else\n        case ${COMP_WORDS[1]}:$before in");
    for (const cli_command *const *c = cli_commands; *c; c++)
        for (const cli_option *o = NULL; (o = cli_next_option(*c, o));) print_bash_values(*c, o);
    printf("            completion:*) files= words=\"bash zsh\" ;;\n");
    printf("            help:*) files= words=\"effects");
    for (const cli_command *const *c = cli_commands; *c; c++) printf(" %s", (*c)->name);
    puts("\" ;;");
    for (const cli_command *const *c = cli_commands; *c; c++) {
        printf("            %s:*) words=\"--help", (*c)->name);
        for (const cli_option *o = NULL; (o = cli_next_option(*c, o));) printf(" --%s", o->name);
        puts("\" ;;");
    }
    puts(
        "        esac\n    fi\n"
        "    # options only after a dash; where no list fits, files: -o default\n"
        "    [[ $files && $word != -* ]] && words=\n"
        "    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n}\n"
        "complete -o default -F _mukca mukca");
}

/* zsh runs the script of bash; the file is its function for mukca, on the first use. */
static void print_zsh(void)
{
    puts("#compdef mukca\nautoload -U +X bashcompinit && bashcompinit");
    print_bash();
    puts("_bash_complete -o default -F _mukca");
}

/* Text for roff: hyphens and backslashes escaped, also a leading dot or quote. */
static void print_roff(const char *text, size_t length)
{
    bool start = true;
    for (const char *end = text + length; text < end; text++) {
        if (start && (*text == '.' || *text == '\'')) fputs("\\&", stdout);
        if (*text == '\\')
            fputs("\\e", stdout);
        else if (*text == '-')
            fputs("\\-", stdout);
        else
            putchar(*text);
        start = *text == '\n';
    }
}

static void print_man_option(const cli_option *o)
{
    char text[80];
    cli_format_option(text, sizeof text, o);
    fputs(".TP\n\\fB", stdout);
    print_roff(text, strlen(text));
    fputs("\\fR\n", stdout);
    print_roff(o->help, strlen(o->help));
    for (int i = 0; o->kind == CLI_CHOICE && o->choices[i]; i++) {
        fputs(i ? ", " : " (", stdout);
        print_roff(o->choices[i], strlen(o->choices[i]));
    }
    puts(o->kind == CLI_CHOICE ? ")" : "");
}

static void print_man_options(const cli_command *c)
{
    int n = 0;
    for (const cli_option *o = NULL; (o = cli_next_option(c, o));)
        if (!o->set) print_man_option(o);
    for (const cli_option *o = NULL; (o = cli_next_option(c, o));) {
        if (!o->set) continue;
        fputs(n++ ? ", " : ".PP\nCommon options: ", stdout);
        print_roff("--", 2);
        print_roff(o->name, strlen(o->name));
    }
    if (n) puts(".");
}

static void print_man_command(const cli_command *c)
{
    char usage[120];
    cli_format_usage(usage, sizeof usage, c);
    printf(".SS \"mukca %s\"\n", c->name);
    fputs(".B mukca ", stdout);
    print_roff(usage, strlen(usage));
    puts("\n.PP");
    print_roff(c->summary, strlen(c->summary));
    puts(".\n.PP");
    for (const char *line = c->description; *line;) {
        size_t length = strcspn(line, "\n");
        if (length == 0)
            fputs(".PP", stdout);
        else
            print_roff(line, length);
        putchar('\n');
        line += length + (line[length] == '\n');
    }
    print_man_options(c);
    puts(".PP\nExample:\n.PP\n.nf");
    print_roff(c->example, strlen(c->example));
    puts("\n.fi");
}

/* The COMMANDS section of mukca(1). */
static void print_man(void)
{
    puts(
        ".SH COMMANDS\n.SS \"Common options\"\nThese mean the same in every command that has "
        "them.");
    for (const cli_option *o = cli_common_options; o->name; o++) print_man_option(o);
    for (const cli_command *const *c = cli_commands; *c; c++) print_man_command(*c);
}

/* command, option, letter, argument: for tests of the documents. */
static void print_options(void)
{
    puts("command\toption\tletter\targument");
    for (const cli_command *const *c = cli_commands; *c; c++)
        for (const cli_option *o = NULL; (o = cli_next_option(*c, o));)
            printf("%s\t--%s\t%.1s\t%s\n", (*c)->name, o->name, o->letter ? &o->letter : "",
                   o->argument ? o->argument : "");
}

/* command and one line of its example, for the test that runs the examples. */
static void print_examples(void)
{
    for (const cli_command *const *c = cli_commands; *c; c++) printf("%s\n", (*c)->example);
}

mukca_status cli_completion(mukca_error *error, const char *what)
{
    static const struct {
        const char *name;
        void (*print)(void);
    } table[] = {{"bash", print_bash},
                 {"zsh", print_zsh},
                 {"man", print_man},
                 {"options", print_options},
                 {"examples", print_examples}};
    for (size_t i = 0; what && i < sizeof table / sizeof *table; i++)
        if (strcmp(table[i].name, what) == 0) {
            table[i].print();
            return MUKCA_OK;
        }
    return mukca_fail(error, MUKCA_USAGE,
                      "completion needs one of bash, zsh, man, options, examples");
}
