/* A session that grows: every acknowledged row survives kills, full disks and resumes. */
#include "io/session_append.h"

#include <errno.h>
#include <signal.h>
#include <sys/resource.h>

#include "arms.h"
#include "io/table.h"
#include "scratch.h"

static mukca_chain chain;
static char path[80];
static mukca_session session;

static int setup(void **state)
{
    make_chain(&chain, "RRR", NULL, "A", 3);
    memcpy(chain.urdf_sha256, "0123456789abcdef", 17);
    if (scratch_setup(state)) return 1;
    snprintf(path, sizeof path, "%s/s.tsv", scratch_folder);
    return 0;
}

static mukca_session_task head(const char *stream)
{
    return (mukca_session_task){
        .chain = &chain, .stream = stream, .channel = "ARM", .type = "t", .has_effort = true};
}

typedef enum { NEW, FORCE, RESUME } how;

static mukca_status begin(mukca_session *s, how h, mukca_session_task task)
{
    task.path = path;
    task.resume = h == RESUME;
    task.force = h == FORCE;
    task.notes = (mukca_notes){note, NULL};
    notes[0] = '\0';
    return mukca_session_open(s, &task, &error);
}

static mukca_status add(int i)
{
    const mukca_capture_sample sample = {.time = 1700000000 + i,
                                         .q = {i / 3., -i, 1e-17},
                                         .spread = {1e-5, 0, 2},
                                         .effort = {i, 0.5, -1}};
    return mukca_session_add(&session, "front left", i % 2 ? "1" : "0", &sample, &error);
}

/* Rows of the file as the project's reader of tables sees them: A1 of row i is expected[i] / 3. */
static void check_rows(const int *expected, int n)
{
    mukca_table table;
    mukca_table_open(&table, path, MUKCA_HEADER, &error);
    int column = mukca_table_require(&table, "A1"), count = 0;
    assert_int_equal(column, 3);
    assert_int_equal(table.n_columns, 3 + 9);
    for (; mukca_table_next(&table); count++)
        assert_true(count < n && mukca_table_number(&table, column) == expected[count] / 3.);
    assert_ok(mukca_table_close(&table));
    assert_int_equal(count, n);
}

static void append_text(const char *text)
{
    FILE *file = fopen(path, "ab");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

TEST(rows_are_added_undone_and_resumed)
{
    mukca_session second;
    mukca_session_task h = head("raw"), corrected = head("corrected"), columns = head("raw");
    unlink(path);
    assert_ok(begin(&session, NEW, h));
    assert_int_equal(mukca_session_delete(&session, "p", "s", &error), MUKCA_INPUT);
    for (int i = 0; i < 5; i++) assert_ok(add(i));
    assert_ok(mukca_session_delete(&session, "front left", "0", &error));
    assert_ok(mukca_session_delete(&session, "front left", "1", &error));
    assert_ok(add(9));
    assert_int_equal(session.n_rows, 4);
    check_rows((const int[]){0, 1, 2, 9}, 4);

    /* one at a time; and not by accident over an old one */
    assert_refused(begin(&second, RESUME, h), "another mukca");
    mukca_session_close(&session);
    assert_refused(begin(&session, NEW, h), "--resume");

    /* a row that was never acknowledged is cut off */
    append_text("front left\t0\t17000");
    assert_ok(begin(&session, RESUME, h));
    assert_part(notes, "18 bytes of an unfinished row removed");
    assert_int_equal(session.n_rows, 4);
    assert_ok(add(10));
    assert_ok(mukca_session_delete(&session, "front left", "0", &error));
    assert_ok(mukca_session_delete(&session, "front left", "1", &error));
    mukca_session_close(&session);
    check_rows((const int[]){0, 1, 2}, 3);

    /* what does not belong together is not mixed */
    assert_refused(begin(&session, RESUME, corrected), "--stream raw");
    columns.has_command = true;
    assert_refused(begin(&session, RESUME, columns), "other columns");
    chain.urdf_sha256[0] = 'x';
    assert_refused(begin(&session, RESUME, h), "another URDF");
    chain.urdf_sha256[0] = '0';

    /* without a sample the old file stays */
    assert_ok(begin(&session, FORCE, h));
    mukca_session_close(&session);
    check_rows((const int[]){0, 1, 2}, 3);
    assert_ok(begin(&session, FORCE, h));
    assert_ok(add(7));
    assert_ok(add(8));
    mukca_session_close(&session);
    check_rows((const int[]){7, 8}, 2);
}

/* A power cut may leave any beginning of the file. */
TEST(any_beginning_can_be_resumed)
{
    mukca_session_task h = head("raw");
    assert_ok(begin(&session, FORCE, h));
    int64_t after[4] = {session.length};
    for (int i = 0; i < 3; i++) {
        assert_ok(add(i));
        after[i + 1] = session.length;
    }
    mukca_session_close(&session);
    char *whole = scratch_read(path);
    for (size_t length = 0; length <= strlen(whole); length++) {
        scratch_bytes("s.tsv", whole, length);
        mukca_status status = begin(&session, RESUME, h);
        if (length > 0 && length < strlen("# mukca session\n")) {
            if (status) continue; /* could be anybody's file */
        } else if (status) {
            fail_msg("cut at %zu: %s", length, error.text);
        }
        int rows = 0;
        while (rows < 3 && (int64_t)length >= after[rows + 1]) rows++;
        assert_int_equal(session.n_rows, rows);
        assert_ok(add(7));
        mukca_session_close(&session);
        int expected[4] = {0, 1, 2, 2};
        expected[rows] = 7;
        check_rows(expected, rows + 1);
    }
    free(whole);
    scratch_file("s.tsv", "# my notes\n");
    assert_refused(begin(&session, RESUME, h), "no header");
}

/* Disk full in mid-session: the row is refused, the others stay, and later ones go on. */
TEST(full_disk_refuses_the_row_only)
{
    mukca_session_task h = head("raw");
    struct rlimit old, small;
    assert_ok(begin(&session, FORCE, h));
    assert_ok(add(1));
    getrlimit(RLIMIT_FSIZE, &old);
    signal(SIGXFSZ, SIG_IGN);
    for (int room = 0; room < 100; room += 11) {
        small.rlim_cur = (rlim_t)session.length + (rlim_t)room;
        small.rlim_max = old.rlim_max;
        setrlimit(RLIMIT_FSIZE, &small);
        assert_error(add(2), MUKCA_MEMORY, error, strerror(EFBIG));
        setrlimit(RLIMIT_FSIZE, &old);
        check_rows((const int[]){1}, 1);
    }
    signal(SIGXFSZ, SIG_DFL);
    assert_ok(add(3));
    mukca_session_close(&session);
    check_rows((const int[]){1, 3}, 2);
}

/* An editor replaces the file, or it is cut or deleted: later rows are refused, as they would be
 * written to the old file; the rows of a file that is gone are written again. */
TEST(changed_file_refuses_the_row)
{
    mukca_session_task h = head("raw");
    char other[90];
    snprintf(other, sizeof other, "%s.other", path);
    for (int k = 0; k < 4; k++) {
        assert_ok(begin(&session, FORCE, h));
        assert_ok(add(1));
        if (k == 0) assert_int_equal(truncate(path, 0), 0);
        if (k == 1) append_text("front left\t0\t1700000001\n");
        if (k == 2) assert_int_equal(rename(path, other), 0);
        if (k == 3) assert_int_equal(unlink(path), 0);
        assert_error(add(2), MUKCA_MEMORY, error, "during the recording; finish, check the file");
        assert_int_equal(mukca_session_delete(&session, "p", "1", &error), MUKCA_MEMORY);
        mukca_session_close(&session);
        if (k >= 2) check_rows((const int[]){1}, 1);
    }
}

TEST(labels)
{
    static const char *const good[] = {"0", "front left", "h\303\266he"};
    static const char *const bad[] = {"",   "#1", "a\tb",  "a\nb", "a,b",
                                      " a", "a ", "\"a\"", "\303", "a\377b"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        assert_true(mukca_session_label_ok(good[i]));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(mukca_session_label_ok(bad[i]));
}

TEST_MAIN(setup, scratch_teardown)
