/* Output files: whole or not at all. */
#include "io/output.h"

#include <fcntl.h>

#include "scratch.h"

static mukca_output output;

static int count_files(void)
{
    int n = 0;
    DIR *dir = opendir(scratch_folder);
    for (struct dirent *e; (e = readdir(dir));) n += e->d_name[0] != '.' || e->d_name[1] == 'o';
    closedir(dir);
    return n;
}

static void check_content(const char *path, const char *wanted)
{
    char *text = scratch_read(path);
    assert_string_equal(text, wanted);
    free(text);
}

TEST(files_appear_when_they_are_whole)
{
    const char *path = scratch_path("out");
    assert_ok(mukca_output_check(path, false, &error));
    assert_int_equal(count_files(), 0);
    assert_ok(mukca_output_open(&output, path, false, &error));
    fputs("hello", output.stream);
    assert_true(access(path, F_OK) != 0);
    assert_ok(mukca_output_close(&output, &error));
    check_content(path, "hello");
    assert_int_equal(count_files(), 1);
    /* one that came meanwhile is another's result */
    const char *late = scratch_path("late");
    assert_ok(mukca_output_open(&output, late, false, &error));
    fputs("mine", output.stream);
    scratch_file("late", "theirs");
    assert_refused(mukca_output_close(&output, &error), "exists already");
    check_content(late, "theirs");
    assert_int_equal(count_files(), 2);
    unlink(late);
    path = scratch_path("out");
    /* a second one needs force; given up half-way it leaves the old one */
    assert_refused(mukca_output_open(&output, path, false, &error),
                   "exists already; --force overwrites it");
    chmod(path, 0640);
    assert_ok(mukca_output_open(&output, path, true, &error));
    fputs("half", output.stream);
    assert_int_equal(mukca_output_finish(&output, MUKCA_INPUT, NULL), MUKCA_INPUT);
    assert_int_equal(mukca_output_finish(&output, MUKCA_INPUT, NULL), MUKCA_INPUT);
    check_content(path, "hello");
    assert_int_equal(count_files(), 1);
    assert_ok(mukca_output_open(&output, path, true, &error));
    fputs("new", output.stream);
    assert_ok(mukca_output_close(&output, &error));
    check_content(path, "new");
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0640);
    unlink(path);
}

TEST(links_stay_links)
{
    char real[128];
    snprintf(real, sizeof real, "%s", scratch_file("real", "old"));
    const char *link = scratch_path("link");
    assert_int_equal(symlink(real, link), 0);
    assert_ok(mukca_output_open(&output, link, true, &error));
    fputs("new", output.stream);
    assert_ok(mukca_output_close(&output, &error));
    check_content(real, "new");
    struct stat info;
    assert_int_equal(lstat(link, &info), 0);
    assert_true(S_ISLNK(info.st_mode));
    unlink(link);
    unlink(real);
}

TEST_MAIN(scratch_setup, scratch_teardown)
