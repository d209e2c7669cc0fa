/* Command lines are parsed by the tables of options, or refused in one line; the tables are
 * consistent. */
#include "cli/cli.h"

#include "scratch.h"

typedef struct {
    cli_common common;
    bool flag;
    const char *text;
    double number, weight, angle;
    int integer, colour, some;
    cli_list each, test;
} test_options;

static const char *const colours[] = {"red", "green", "blue", NULL};

#define ROW(member, letter, kind, argument, choices)                              \
    {                                                                             \
#member, letter, kind, argument, "a " #member, choices, 0, 0, NULL, NULL, \
            offsetof(test_options, member), 0                                     \
    }
static const cli_option options[] = {
    ROW(flag, 'f', CLI_FLAG, NULL, NULL),
    ROW(text, 't', CLI_TEXT, "TEXT", NULL),
    ROW(number, 0, CLI_NUMBER, "N", NULL),
    ROW(integer, 'i', CLI_INTEGER, "N", NULL),
    ROW(colour, 0, CLI_CHOICE, "COLOUR", colours),
    ROW(each, 'e', CLI_TEXTS, "TEXT", NULL),
    ROW(test, 0, CLI_REST, "DATA...", NULL),
    CLI_OPTION(test_options, some, "some", CLI_INTEGER, "N", "a few", .least = 2, .most = 9),
    CLI_OPTION(test_options, weight, "weight", CLI_NUMBER, "W", "a weight", .most = INFINITY),
    CLI_OPTION(test_options, angle, "angle", CLI_POSITIVE, "DEG", "an angle", .most = 180,
               .needs = "some or --weight", .excludes = "flag text"),
    CLI_OUTPUT_OPTION("output"),
    {.name = NULL}};

static const test_options defaults = {.number = 7, .colour = 1};

static const cli_command command = {.name = "try",
                                    .synopsis = "DATA...",
                                    .with = CLI_WITH_MODEL | CLI_WITH_DISTANCE,
                                    .options = options,
                                    .options_size = sizeof(test_options),
                                    .defaults = &defaults};

static cli_call call; /* of the last line */
static bool help;

/* Parse words parted by spaces. */
static mukca_status parse(const char *line)
{
    static char buffer[512];
    static char *words[32];
    int n = 0;
    snprintf(buffer, sizeof buffer, "%s", line);
    for (char *word = strtok(buffer, " "); word; word = strtok(NULL, " ")) words[n++] = word;
    cli_call_free(&call);
    call = (cli_call){.command = &command};
    return cli_parse(&call, &help, n, words);
}

TEST(good_lines_are_understood)
{
    assert_ok(parse("a --flag -t hello --number=-1.5 -i12 --colour blue b -e x --each=y"));
    const test_options *o = call.options;
    assert_true(o->flag);
    assert_string_equal(o->text, "hello");
    assert_true(o->number == -1.5 && o->integer == 12 && o->colour == 2);
    assert_int_equal(o->each.n, 2);
    assert_string_equal(o->each.items[1], "y");
    assert_int_equal(call.arguments.n, 2);
    assert_string_equal(call.arguments.items[1], "b");
    assert_false(help);

    assert_ok(parse("a"));
    o = call.options;
    assert_true(o->number == 7 && o->colour == 1 && !o->flag && !o->text);
    assert_true(call.common->distance == MUKCA_DISTANCE && call.common->threads >= 1);

    assert_ok(parse("a --test b c - --flag d --test e"));
    o = call.options;
    assert_int_equal(o->test.n, 4);
    assert_string_equal(o->test.items[2], "-");
    assert_string_equal(o->test.items[3], "e");
    assert_int_equal(call.arguments.n, 2);

    assert_ok(parse("--test b -- -x --flag"));
    o = call.options;
    assert_int_equal(o->test.n, 1);
    assert_string_equal(call.arguments.items[1], "--flag");
    assert_false(o->flag);

    assert_ok(parse("a -qvf --gravity 0,9.8,-1e-3 --distance 0.08 -o -"));
    o = call.options;
    assert_true(o->common.quiet && o->common.verbose && o->flag);
    assert_true(o->common.arm.gravity[1] == 9.8 && o->common.arm.gravity[2] == -1e-3);
    assert_true(call.common->distance == 0.08);
    assert_string_equal(call.common->output, "-");

    assert_ok(parse("a --angle 180 --some 2 --weight 0"));
    o = call.options;
    assert_true(o->some == 2 && o->weight == 0 && o->angle == 180);

    assert_ok(parse("--help"));
    assert_true(help);
    assert_ok(parse("-h"));
    assert_true(help);
}

TEST(bad_lines_get_one_clear_line)
{
    static const bad_text cases[] = {
        {"", "needs DATA...; see `mukca help try`"},
        {"a --flags", "unknown option --flags; did you mean --flag?"},
        {"a --numbre 3", "did you mean --number?"},
        {"a --zzz=3", "unknown option --zzz; see `mukca help try`"},
        {"a -z", "unknown option -z"},
        {"a -fz", "unknown option -fz"},
        {"a --flag=1", "--flag takes no value"},
        {"a --text", "--text needs TEXT"},
        {"a -t", "--text needs TEXT"},
        {"a --number x", "--number x: must be a number"},
        {"a --number 1,5", "must be a number"},
        {"a --integer 1.5", "must be a whole number"},
        {"a --integer 99999999999", "must be a whole number"},
        {"a --some 1", "--some 1: must be a whole number, 2 to 9"},
        {"a --some 10", "2 to 9"},
        {"a --weight -1", "--weight -1: must be a number, 0 or more"},
        {"a --angle 0", "--angle 0: must be a number above 0, at most 180, in degrees"},
        {"a --angle 181", "at most 180"},
        {"a --angle 1", "--angle needs --some or --weight"},
        {"a --weight 1 --angle 1 -f", "--angle and --flag exclude each other"},
        {"a --colour pink", "--colour pink: must be one of red, green, blue"},
        {"a --test --flag", "--test needs DATA..."},
        {"a --distance 0", "--distance 0: must be a number above 0"},
        {"a --gravity 1,2", "must be three numbers"},
        {"a --gravity 0,0,0", "not all 0"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        mukca_status status = parse(cases[i].text);
        assert_error(status, MUKCA_USAGE, call.error, cases[i].part);
    }
}

/* Each name in "poses or --at" is an option of the command. */
static void check_names(const cli_command *of, const char *names)
{
    char list[256];
    snprintf(list, sizeof list, "%s", names ? names : "");
    for (char *name = strtok(list, " "); name; name = strtok(NULL, " ")) {
        name += strspn(name, "-");
        const cli_option *o = cli_next_option(of, NULL);
        while (o && strcmp(o->name, name) != 0) o = cli_next_option(of, o);
        if (!o && strcmp(name, "or") != 0) fail_msg("%s has no --%s", of->name, name);
    }
}

TEST(tables_of_options_are_consistent)
{
    for (const cli_command *const *c = cli_commands; *c; c++) {
        int n = 0;
        assert_true((*c)->summary[strlen((*c)->summary) - 1] != '.');
        assert_ptr_equal(cli_find_command((*c)->name), *c);
        assert_true((*c)->options_size >= sizeof(cli_common));
        for (const cli_option *o = NULL; (o = cli_next_option(*c, o));) {
            assert_true((o->argument == NULL) == (o->kind == CLI_FLAG));
            assert_true((o->choices != NULL) == (o->kind == CLI_CHOICE));
            assert_true(o->offset < (*c)->options_size);
            assert_true(n++ < CLI_MOST_OPTIONS);
            check_names(*c, o->needs);
            check_names(*c, o->excludes);
            for (const cli_option *p = NULL; (p = cli_next_option(*c, p)) != o;) {
                assert_string_not_equal(p->name, o->name);
                assert_true(!o->letter || o->letter != p->letter);
            }
        }
    }
}

TEST(json_has_no_nan)
{
    const double values[] = {1 / 3., (double)NAN, HUGE_VAL, -HUGE_VAL, 0};
    json_t *root = json_pack("{s:o, s:o, s:o}", "v", cli_json_reals(values, 5), "t",
                             cli_json_text("a"), "n", cli_json_text(NULL));
    char *text = json_dumps(root, JSON_REAL_PRECISION(17) | JSON_COMPACT | JSON_SORT_KEYS);
    assert_string_equal(text,
                        "{\"n\":null,\"t\":\"a\",\"v\":[0.33333333333333331,null,null,null,0.0]}");
    free(text);
    json_decref(root);
}

TEST_MAIN(scratch_setup, scratch_teardown)
