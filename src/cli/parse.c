/* Parsing of command lines by the option tables. */
#define _GNU_SOURCE /* sched_getaffinity() */
#include "cli/cli.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <sched.h>
#include <string.h>

#include "base/number.h"
#include "base/suggest.h"
#include "base/text.h"

const cli_option *cli_next_option(const cli_command *command, const cli_option *o)
{
    o = o ? o + 1 : command->options;
    if (!o || (!o->name && !o->set)) o = cli_common_options;
    while (o->set && !(o->set & (command->with | CLI_WITH_ALL))) o++;
    return o->name ? o : NULL;
}

static const cli_option *find_option(const cli_command *command, const char *name, size_t length)
{
    for (const cli_option *o = NULL; (o = cli_next_option(command, o));)
        if (strlen(o->name) == length && strncmp(o->name, name, length) == 0) return o;
    return NULL;
}

static mukca_status unknown_option(cli_call *call, const char *word)
{
    char name[64];
    const char *meant = NULL;
    int best = 99;
    size_t length = strcspn(word, "=");
    snprintf(name, sizeof name, "%.*s", (int)(length < sizeof name ? length : sizeof name - 1),
             word);
    for (const cli_option *o = NULL; (o = cli_next_option(call->command, o));)
        if (mukca_suggest_better(&best, name + strspn(name, "-"), o->name)) meant = o->name;
    if (meant)
        return cli_fail(call, MUKCA_USAGE, "unknown option %s; did you mean --%s?", name, meant);
    return cli_fail(call, MUKCA_USAGE, "unknown option %s; see `mukca help %s`", name,
                    call->command->name);
}

mukca_status cli_fail_effect(mukca_error *error, const char *option, const char *name)
{
    const char *meant = NULL;
    char text[MUKCA_SUGGEST_TEXT];
    int best = 99;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++)
        if (mukca_suggest_better(&best, name, mukca_effect_table[kind]->name))
            meant = mukca_effect_table[kind]->name;
    return mukca_fail(error, MUKCA_USAGE, "%s: no effect is called '%.60s'; %s", option, name,
                      mukca_suggest_text(text, meant, "`mukca help effects` lists them"));
}

int cli_read_list(double *values, int most, const char *text)
{
    char number[64];
    int n = 0;
    while (mukca_text_item(number, sizeof number, &text))
        if (n == most || !mukca_number_parse(&values[n++], number)) return -1;
    return n;
}

/* Append one of the call's words. */
static mukca_status append(cli_call *call, cli_list *list, const char *item)
{
    if (!list->items) list->items = MUKCA_TAKE(&call->pool, const char *, call->argc);
    if (!list->items) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    list->items[list->n++] = item;
    return MUKCA_OK;
}

/* ", in m", by the argument's name in help; "": no unit. */
static const char *unit_words(const cli_option *option)
{
    static const char *const table[][2] = {
        {"M", ", in m"}, {"S", ", in s"}, {"RAD", ", in rad"}, {"DEG", ", in degrees"}};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (strcmp(option->argument, table[i][0]) == 0) return table[i][1];
    return "";
}

void *cli_option_member(const cli_call *call, const cli_option *option)
{
    return (char *)call->options + option->offset;
}

static bool store_integer(int *value, const char *text)
{
    char *end;
    errno = 0;
    long number = strtol(text, &end, 10);
    *value = (int)number;
    return end != text && !*end && !errno && number <= INT_MAX && number >= INT_MIN;
}

static bool store_choice(int *value, const char *const *choices, const char *text)
{
    for (*value = 0; choices[*value]; ++*value)
        if (strcmp(choices[*value], text) == 0) return true;
    return false;
}

static bool in_range(double value, const cli_option *option)
{
    return (option->least == 0 && option->most == 0) ||
           (value >= option->least && value <= option->most);
}

/* ", 1 to 1000"; ", at most 180"; "" without a range. */
static void describe_range(char text[64], const cli_option *option)
{
    text[0] = '\0';
    if (option->least == 0 && option->most == 0) return;
    if (option->kind == CLI_POSITIVE)
        snprintf(text, 64, ", at most %.7g", option->most);
    else if (isinf(option->most))
        snprintf(text, 64, ", %.7g or more", option->least);
    else
        snprintf(text, 64, ", %.7g to %.7g", option->least, option->most);
}

/* Parse and store a value; false: invalid text. */
static bool store(void *at, const cli_option *option, const char *text)
{
    double *v = at;
    switch (option->kind) {
        case CLI_NUMBER:
        case CLI_POSITIVE:
            return cli_read_list(v, 1, text) == 1 && in_range(*v, option) &&
                   (option->kind == CLI_NUMBER || *v > 0);
        case CLI_VECTOR:
            return cli_read_list(v, 3, text) == 3 && (v[0] != 0 || v[1] != 0 || v[2] != 0);
        case CLI_INTEGER:
            return store_integer(at, text) && in_range(*(int *)at, option);
        case CLI_CHOICE:
            return store_choice(at, option->choices, text);
        default:
            *(const char **)at = text;
            return true;
    }
}

static mukca_status set_value(cli_call *call, const cli_option *option, const char *text)
{
    static const char *const wanted[] = {
        [CLI_NUMBER] = "a number",
        [CLI_POSITIVE] = "a number above 0",
        [CLI_VECTOR] = "three numbers with commas between, not all 0",
        [CLI_INTEGER] = "a whole number",
        [CLI_CHOICE] = "one of",
    };
    void *at = cli_option_member(call, option);
    char list[160] = "", range[64];
    mukca_text names = MUKCA_TEXT(list);
    if (!*text) /* from an unset variable in a script */
        return cli_fail(call, MUKCA_USAGE, "--%s needs %s, and not an empty text", option->name,
                        option->argument);
    if (option->kind == CLI_TEXTS || option->kind == CLI_REST) return append(call, at, text);
    if (store(at, option, text)) return MUKCA_OK;
    for (int i = 0; option->kind == CLI_CHOICE && option->choices[i]; i++)
        mukca_text_put(&names, "%s %s", i ? "," : "", option->choices[i]);
    describe_range(range, option);
    return cli_fail(call, MUKCA_USAGE, "--%s %.40s: must be %s%s%s%s", option->name, text,
                    wanted[option->kind], list, range, unit_words(option));
}

/* Number of arguments before the first option. */
static int count_plain(int argc, char **argv)
{
    int n = 0;
    while (n < argc && (argv[n][0] != '-' || argv[n][1] == '\0')) n++;
    return n;
}

/* Remember that an option is given, in these words. */
static void note_given(cli_call *call, const cli_option *option, char *const *words, int n)
{
    int i = 0;
    while (i < call->n_given && call->given[i].option != option) i++;
    call->given[i] = (cli_given){option, words, n};
    if (i == call->n_given) call->n_given++;
}

/* Is the name among these, as in "poses or --at"? */
static bool is_listed(const char *names, const char *name)
{
    const size_t length = strlen(name);
    for (; names && *names; names += strcspn(names, " "), names += strspn(names, " -"))
        if (strcspn(names, " ") == length && strncmp(names, name, length) == 0) return true;
    return false;
}

/* Check what the options that are given need and exclude. */
static mukca_status check_given(cli_call *call)
{
    for (int i = 0; i < call->n_given; i++) {
        const cli_option *o = call->given[i].option;
        bool met = !o->needs;
        for (int k = 0; k < call->n_given; k++) {
            const char *other = call->given[k].option->name;
            met |= is_listed(o->needs, other);
            if (is_listed(o->excludes, other))
                return cli_fail(call, MUKCA_USAGE, "--%s and --%s exclude each other", o->name,
                                other);
        }
        if (!met) return cli_fail(call, MUKCA_USAGE, "--%s needs --%s", o->name, o->needs);
    }
    return MUKCA_OK;
}

/* One option at argv[0] with the value in `inlined` (or NULL) or in the next arguments; *used:
 * number of arguments consumed. */
static mukca_status take_option(cli_call *call, int *used, const cli_option *option,
                                const char *inlined, int argc, char **argv)
{
    int n = inlined || option->kind == CLI_FLAG ? 0
            : option->kind == CLI_REST          ? count_plain(argc - 1, argv + 1)
                                                : argc > 1;
    mukca_status status = MUKCA_OK;
    *used = 1 + n;
    note_given(call, option, argv, *used);
    if (option->kind == CLI_FLAG) {
        if (inlined) return cli_fail(call, MUKCA_USAGE, "--%s takes no value", option->name);
        *(bool *)cli_option_member(call, option) = true;
        return MUKCA_OK;
    }
    if (inlined) return set_value(call, option, inlined);
    if (n == 0) return cli_fail(call, MUKCA_USAGE, "--%s needs %s", option->name, option->argument);
    for (int i = 1; i <= n && status == MUKCA_OK; i++) status = set_value(call, option, argv[i]);
    return status;
}

static mukca_status parse_letters(cli_call *call, bool *help, int *used, int argc, char **argv)
{
    const char *word = argv[0];
    *used = 1;
    for (const char *c = word + 1; *c; c++) {
        const cli_option *o = cli_next_option(call->command, NULL);
        while (o && o->letter != *c) o = cli_next_option(call->command, o);
        if (!o && *c == 'h') {
            *help = true;
            continue;
        }
        if (!o) return unknown_option(call, word);
        if (o->kind != CLI_FLAG) return take_option(call, used, o, c[1] ? c + 1 : NULL, argc, argv);
        take_option(call, used, o, NULL, 1, argv);
    }
    return MUKCA_OK;
}

/* Compare the number of arguments with the synopsis: words in brackets are optional, dots mean any
 * number. */
static mukca_status check_arguments(cli_call *call)
{
    const cli_command *c = call->command;
    const bool many = strstr(c->synopsis, "...") != NULL;
    int least = 0;
    for (const char *word = c->synopsis; *word; word += strspn(word, " ")) {
        least += *word != '[';
        word += strcspn(word, " ");
    }
    if (call->arguments.n < least)
        return cli_fail(call, MUKCA_USAGE, "needs %s; see `mukca help %s`", c->synopsis, c->name);
    if (!many && call->arguments.n > least)
        return cli_fail(call, MUKCA_USAGE, "unexpected argument '%.60s'; see `mukca help %s`",
                        call->arguments.items[least], c->name);
    return MUKCA_OK;
}

/* Those that the process may use. */
static int count_cores(void)
{
    cpu_set_t set;
    return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

mukca_status cli_parse(cli_call *call, bool *help, int argc, char **argv)
{
    *help = false;
    call->argc = argc;
    call->argv = argv;
    call->options = mukca_pool_take(&call->pool, 1, call->command->options_size);
    call->common = call->options;
    if (!call->options) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    if (call->command->defaults)
        memcpy(call->options, call->command->defaults, call->command->options_size);
    call->common->distance = MUKCA_DISTANCE;
    call->common->distance_sd = MUKCA_DISTANCE_SIGMA;
    call->common->threads = count_cores();
    bool plain = false;
    for (int i = 0; i < argc;) {
        const char *word = argv[i];
        int used = 1;
        mukca_status status = MUKCA_OK;
        if (plain || word[0] != '-' || word[1] == '\0') {
            if (!*word)
                return cli_fail(call, MUKCA_USAGE, "an argument is empty; see `mukca help %s`",
                                call->command->name);
            status = append(call, &call->arguments, word);
        } else if (strcmp(word, "--") == 0) {
            plain = true;
        } else if (strcmp(word, "--help") == 0) {
            *help = true;
        } else if (word[1] == '-') {
            size_t length = strcspn(word + 2, "=");
            const cli_option *o = find_option(call->command, word + 2, length);
            if (!o) return unknown_option(call, word);
            const char *inlined = word[2 + length] ? word + 3 + length : NULL;
            status = take_option(call, &used, o, inlined, argc - i, argv + i);
        } else {
            status = parse_letters(call, help, &used, argc - i, argv + i);
        }
        if (status != MUKCA_OK) return status;
        i += used;
    }
    if (*help) return MUKCA_OK;
    const mukca_status status = check_given(call);
    return status == MUKCA_OK ? check_arguments(call) : status;
}

void cli_call_free(cli_call *call)
{
    mukca_pool_free(&call->pool);
    call->options = NULL;
    call->common = NULL;
}
