/* What serve keeps across restarts: a damaged file is refused with its line, never obeyed. */
#include "record/server.h"

#include "scratch.h"

static mukca_server server;

static mukca_status load(const char *text)
{
    static mukca_server_options options;
    options.folder = scratch_folder;
    server.options = &options;
    scratch_file("state.tsv", text);
    return mukca_server_load_state(&server, &error);
}

TEST(what_is_saved_is_read)
{
    assert_ok(
        load("session\ta\nplacement\th\303\266he\nsocket\t0\nrows\t12\nfinished\t1\n"
             "model\ta.offsets.tsv\nmodel_stream\traw\nlater\tx\n"
             "candidate\tb.c.effects.tsv\ncandidate_stream\tcorrected\n"));
    const mukca_server_state read = server.state;
    assert_string_equal(read.placement, "h\303\266he");
    assert_string_equal(read.candidate, "b.c.effects.tsv");
    memset(&server.saved, 0xff, sizeof server.saved);
    assert_ok(mukca_server_save_state(&server, &error));
    assert_ok(mukca_server_load_state(&server, &error));
    assert_memory_equal(&server.state, &read, sizeof read);
}

TEST(a_damaged_line_is_named)
{
    static const char *const lines[] = {
        "session\t../a",
        "session\t.a",
        "socket\t0123456789012345678901234567890123456789012345678901234567890123",
        "model\t../x.offsets.tsv",
        "model\t.offsets.tsv",
        "model\tx.tsv",
        "candidate\tresults/x.effects.tsv",
    };
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        char text[200], named[40];
        snprintf(text, sizeof text, "rows\t3\n%s\n", lines[i]);
        snprintf(named, sizeof named, "state.tsv:2: %.*s is damaged", (int)strcspn(lines[i], "\t"),
                 lines[i]);
        assert_refused(load(text), named);
    }
}

/* The bytes behind a text's end do not count as a change. */
TEST(the_last_of_two_lines_counts)
{
    assert_ok(load("session\tlonger\nsession\ta\n"));
    const mukca_server_state expected = {.session = "a"};
    assert_memory_equal(&server.state, &expected, sizeof expected);
}

TEST_MAIN(scratch_setup, scratch_teardown)
