/* Event logs of liblcm are read; damage is skipped, and a log that is cut ends. */
#include <lcm/lcm.h>

#include "lcm/link.h"
#include "scratch.h"

static const char *path;

static void write_log(int n)
{
    char arm[] = "ARM", other[] = "A+B", data[40];
    path = scratch_file("log", "");
    lcm_eventlog_t *log = lcm_eventlog_create(path, "w");
    assert_non_null(log);
    for (int i = 0; i < n; i++) {
        memset(data, 'a' + i % 26, sizeof data);
        lcm_eventlog_event_t event = {.timestamp = 1000 + i,
                                      .channellen = 3,
                                      .datalen = i % 40,
                                      .channel = i % 3 ? arm : other,
                                      .data = data};
        assert_int_equal(lcm_eventlog_write_event(log, &event), 0);
    }
    lcm_eventlog_destroy(log);
}

TEST(we_read_what_liblcm_writes)
{
    mukca_lcm_log log;
    mukca_lcm_packet event;
    write_log(50);
    assert_ok(mukca_lcm_log_open(&log, path, &error));
    for (int i = 0; i < 50; i++) {
        assert_true(mukca_lcm_log_read(&event, &log));
        assert_int_equal(event.time, 1000 + i);
        assert_string_equal(event.channel, i % 3 ? "ARM" : "A+B");
        assert_int_equal(event.size, i % 40);
    }
    assert_false(mukca_lcm_log_read(&event, &log));
    assert_int_equal(log.skipped, 0);
    mukca_lcm_log_close(&log);
}

/* Overwrite 12 bytes anywhere, a false beginning among them: few of the small events nearby are
 * lost, and reading goes on behind them. */
TEST(damage_is_skipped)
{
    for (int at = 0; at < 3000; at += 7) {
        write_log(50);
        FILE *file = fopen(path, "r+b");
        assert_non_null(file);
        fseek(file, at, SEEK_SET);
        fwrite("\x7f\xff\xff\xff\xed\xa1\xda\x01\x7f\xff\xff\xff", 1, 12, file);
        fclose(file);
        mukca_lcm_log log;
        mukca_lcm_packet event;
        assert_ok(mukca_lcm_log_open(&log, path, &error));
        int n = 0;
        while (mukca_lcm_log_read(&event, &log)) n++;
        mukca_lcm_log_close(&log);
        if (!(n >= 45 && n <= 50)) fail_msg("damage at %d: %d events of 50", at, n);
    }
}

/* A time from which differences would overflow belongs to no recording. */
TEST(an_event_of_no_time_is_skipped)
{
    const unsigned char never[] = {0x7f, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff};
    mukca_lcm_log log;
    mukca_lcm_packet event;
    write_log(3);
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    fseek(file, 12, SEEK_SET); /* the first event's */
    fwrite(never, 1, sizeof never, file);
    fclose(file);
    assert_ok(mukca_lcm_log_open(&log, path, &error));
    assert_true(mukca_lcm_log_read(&event, &log));
    assert_int_equal(event.time, 1001);
    assert_int_equal(log.skipped, 28 + 3); /* its header and its channel */
    mukca_lcm_log_close(&log);
}

TEST(a_log_cut_while_it_is_read_ends)
{
    mukca_lcm_log log;
    mukca_lcm_packet event;
    write_log(5000); /* many pages */
    assert_ok(mukca_lcm_log_open(&log, path, &error));
    assert_true(mukca_lcm_log_read(&event, &log));
    assert_int_equal(truncate(path, 0), 0);
    int n = 0;
    while (mukca_lcm_log_read(&event, &log)) n++;
    assert_true(n < 4999);
    mukca_lcm_log_close(&log);
}

TEST_MAIN(scratch_setup, scratch_teardown)
