/* Tables: every dialect that people save, and a clear line for what is none. */
#include "io/table.h"

#include "scratch.h"

static mukca_table table;

/* Read all of a table; status of the first failure. */
static mukca_status read_all(const char *path, mukca_table_kind kind)
{
    mukca_table_open(&table, path, kind, &error);
    while (mukca_table_next(&table))
        for (int c = 0; c < table.n_columns; c++) mukca_table_number(&table, c);
    return mukca_table_close(&table);
}

TEST(dialects_are_read_alike)
{
    static const char *const texts[] = {
        "a\tb c\n1\t2\n\n3\t4\n",
        "# one\n#two\na\tb c\n1\t2\n# three\n3\t4",
        "\xEF\xBB\xBF"
        "a,b c\r\n1,2\r\n3,4\r\n",
        "\"a\" ,  \"b c\"\n 1 , 2 \n\"3\",\"4\"\n\n\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        double v[4];
        const char *path = scratch_file("t", texts[i]);
        assert_ok(mukca_table_open(&table, path, MUKCA_HEADER, &error));
        assert_int_equal(table.n_columns, 2);
        assert_int_equal(mukca_table_find(&table, "b c"), 1);
        assert_int_equal(mukca_table_find(&table, "b"), -1);
        for (int r = 0; r < 2; r++) {
            assert_true(mukca_table_next(&table));
            for (int c = 0; c < 2; c++) v[2 * r + c] = mukca_table_number(&table, c);
        }
        assert_false(mukca_table_next(&table));
        assert_int_equal(table.row, 2);
        for (int k = 0; k < 4; k++) assert_true(v[k] == k + 1);
        if (i == 1) assert_string_equal(table.comments, "# one\n#two\n");
        mukca_table_close(&table);
    }
}

TEST(tables_may_lack_a_header)
{
    const char *path = scratch_file("t.csv", "1.5,2\n3,4\n");
    for (int i = 0; i < 2; i++) {
        assert_ok(mukca_table_open(&table, path, i ? MUKCA_EITHER : MUKCA_NO_HEADER, &error));
        assert_null(table.header);
        assert_true(mukca_table_next(&table));
        assert_string_equal(table.cell[0], "1.5");
        assert_int_equal(table.line, 1);
        assert_true(mukca_table_next(&table));
        assert_string_equal(table.cell[1], "4");
        mukca_table_close(&table);
    }
    path = scratch_file("t.csv", "q1,2\n3,4\n");
    assert_ok(mukca_table_open(&table, path, MUKCA_EITHER, &error));
    assert_non_null(table.header);
    mukca_table_close(&table);
}

/* As spreadsheets of half of Europe write them. */
TEST(semicolons_may_have_decimal_commas)
{
    static const char *const texts[] = {"a;b\n1,5;-2e-3\n", "1,5;-0,002\n", "1.5;\"-0,002\"\n"};
    double v[2];
    for (int i = 0; i < 3; i++) {
        const char *path = scratch_file("t.csv", texts[i]);
        assert_ok(mukca_table_open(&table, path, MUKCA_EITHER, &error));
        assert_int_equal(table.header != NULL, i == 0);
        assert_true(mukca_table_next(&table));
        for (int c = 0; c < 2; c++) v[c] = mukca_table_number(&table, c);
        assert_true(v[0] == 1.5 && v[1] == -0.002);
        mukca_table_close(&table);
    }
    /* a list of names that holds one semicolon has commas */
    assert_ok(mukca_table_open(&table, scratch_file("t.csv", "a,b,c;d\n"), MUKCA_HEADER, &error));
    assert_int_equal(table.n_columns, 3);
    mukca_table_close(&table);
    static const bad_text bad[] = {
        {"a\tb\n0,75\t1\n", "t.csv:2: column 'a': '0,75' has a decimal comma; write a point"},
        {"a;b\n1,2,3;4\n", "t.csv:2: column 'a': '1,2,3' has a decimal comma"},
        {"a;b\n1.234,5;4\n", "'1.234,5' is not a finite number"},
        {"a;b\n1,5\n", "t.csv:2: 1 columns, but 2 in the header"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const char *path = scratch_file("t.csv", bad[i].text);
        assert_refused(read_all(path, MUKCA_HEADER), bad[i].part);
    }
}

TEST(long_lines_are_read_whole)
{
    enum { N = 3000 };
    char *text = malloc(N * 16 + 2);
    size_t length = 0;
    for (int row = 0; row < 2; row++) {
        for (int c = 0; c < N; c++)
            length += (size_t)sprintf(text + length, row ? "%s%d" : "%sc%d", c ? "\t" : "", c);
        text[length++] = '\n';
        if (row == 0) assert_true(length < N * 8);
    }
    const char *path = scratch_bytes("long", text, length);
    assert_ok(mukca_table_open(&table, path, MUKCA_HEADER, &error));
    assert_int_equal(table.n_columns, N);
    assert_true(mukca_table_next(&table));
    assert_string_equal(table.cell[N - 1], "2999");
    assert_string_equal(table.header[N - 1], "c2999");
    mukca_table_close(&table);
    free(text);
}

/* Rows read ahead are those of a table that is not, up to and including its first fault. */
TEST(rows_are_read_ahead)
{
    enum { ROWS = 60000 }; /* more than a MiB: several blocks */
    static char text[40 * ROWS];
    static const char *const ends[] = {"1 m, 2.5\n", "1,x\n", "1\n", "7,8"};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        mukca_table plain;
        mukca_error failure = {.text = ""};
        char *at = text + sprintf(text, "a [mm],name,b\n");
        for (int r = 0; r < ROWS; r++)
            at += sprintf(at, r % 1000 ? "%.17g,%d,%d\n" : "# %g\n\n%d, \"%d\" ,nan\n", r / 3.0, r,
                          -r);
        sprintf(at, "3,%s", ends[i]);
        const char *path = scratch_file("t.csv", text);
        assert_ok(mukca_table_open(&plain, path, MUKCA_HEADER, &failure));
        assert_ok(mukca_table_open(&table, path, MUKCA_HEADER, &error));
        mukca_table_use(&table, "a");
        mukca_table_read_ahead(&table);
        assert_non_null(table.source);
        while (mukca_table_next(&plain)) {
            assert_true(mukca_table_next(&table));
            assert_int_equal(table.line, plain.line);
            for (int c = 0; c < 3; c++) assert_string_equal(table.cell[c], plain.cell[c]);
            assert_true(mukca_table_number(&table, 0) == mukca_table_number(&plain, 0));
            if (plain.row % 1000 != 1 || plain.row > ROWS)
                assert_true(mukca_table_number(&table, 2) == mukca_table_number(&plain, 2));
        }
        assert_false(mukca_table_next(&table));
        assert_int_equal(table.status, plain.status);
        assert_int_equal(table.row, plain.row);
        assert_int_equal(table.cut_off, plain.cut_off);
        if (plain.status) assert_string_equal(error.text, failure.text);
        mukca_table_close(&plain);
        mukca_table_close(&table);
    }
    assert_ok(mukca_table_open(&table, scratch_file("t.csv", text), MUKCA_HEADER, &error));
    mukca_table_read_ahead(&table);
    assert_true(mukca_table_next(&table));
    assert_ok(mukca_table_close(&table)); /* with most rows unread */
}

TEST_MAIN(scratch_setup, scratch_teardown)
