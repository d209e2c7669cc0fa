/* Event logs: ours is read by liblcm and the other way round; damage is skipped; links replay them.
 */
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include <lcm/lcm.h>

#include "close.h"
#include "lcm/link.h"
#include "lcm/log.h"

static char path[] = "/tmp/mukca_test_log_XXXXXX";

static int setup(void **state)
{
    (void)state;
    int fd = mkstemp(path);
    return fd < 0 || close(fd);
}

static int teardown(void **state)
{
    (void)state;
    return unlink(path);
}

static void write_log(int n)
{
    mukca_lcm_log log;
    mukca_error error;
    assert_int_equal(mukca_lcm_log_create(&log, path, true, &error), MUKCA_OK);
    for (int i = 0; i < n; i++) {
        char data[40];
        memset(data, 'a' + i % 26, sizeof data);
        assert_int_equal(mukca_lcm_log_write(&log, i % 3 ? "ARM" : "A+B", 1000 + i, data,
                                             (size_t)(i % 40), &error),
                         MUKCA_OK);
    }
    mukca_lcm_log_close(&log);
}

TEST(liblcm_reads_what_we_write)
{
    write_log(50);
    lcm_eventlog_t *log = lcm_eventlog_create(path, "r");
    assert_non_null(log);
    for (int i = 0; i < 50; i++) {
        lcm_eventlog_event_t *event = lcm_eventlog_read_next_event(log);
        assert_non_null(event);
        assert_int_equal(event->eventnum, i);
        assert_int_equal(event->timestamp, 1000 + i);
        assert_string_equal(event->channel, i % 3 ? "ARM" : "A+B");
        assert_int_equal(event->datalen, i % 40);
        lcm_eventlog_free_event(event);
    }
    assert_null(lcm_eventlog_read_next_event(log));
    lcm_eventlog_destroy(log);
}

TEST(we_read_what_liblcm_writes)
{
    char channel[] = "PANDA_STATUS", data[] = "hello";
    lcm_eventlog_t *out = lcm_eventlog_create(path, "w");
    assert_non_null(out);
    for (int i = 0; i < 5; i++) {
        lcm_eventlog_event_t event = {.timestamp = 7 + i,
                                      .channellen = (int32_t)strlen(channel),
                                      .datalen = 5,
                                      .channel = channel,
                                      .data = data};
        assert_int_equal(lcm_eventlog_write_event(out, &event), 0);
    }
    lcm_eventlog_destroy(out);
    mukca_lcm_log log;
    mukca_lcm_event event;
    mukca_error error;
    assert_int_equal(mukca_lcm_log_open(&log, path, &error), MUKCA_OK);
    for (int i = 0; i < 5; i++) {
        assert_true(mukca_lcm_log_read(&log, &event));
        assert_int_equal(event.time, 7 + i);
        assert_string_equal(event.channel, channel);
        assert_int_equal(event.size, 5);
        assert_memory_equal(event.data, "hello", 5);
    }
    assert_false(mukca_lcm_log_read(&log, &event));
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
        mukca_lcm_event event;
        mukca_error error;
        assert_int_equal(mukca_lcm_log_open(&log, path, &error), MUKCA_OK);
        int n = 0;
        while (mukca_lcm_log_read(&log, &event)) n++;
        mukca_lcm_log_close(&log);
        if (!(n >= 45 && n <= 50)) fail_msg("damage at %d: %d events of 50", at, n);
    }
}

typedef struct {
    int n, arm;
    int64_t last;
} heard;

static void hear(void *context, const mukca_lcm_packet *packet)
{
    heard *h = context;
    h->n++;
    h->arm += strcmp(packet->channel, "ARM") == 0;
    h->last = packet->time;
}

TEST(links_replay_logs)
{
    char url[100];
    mukca_lcm_link *link;
    mukca_error error = {0};
    write_log(600);
    snprintf(url, sizeof url, "file://%s", path);
    for (int all = 0; all < 2; all++) {
        heard h = {0};
        mukca_status status;
        assert_int_equal(
            mukca_lcm_link_open(&link, &(mukca_lcm_network){.url = url}, hear, &h, &error),
            MUKCA_OK);
        assert_true(mukca_lcm_link_replays(link));
        assert_int_equal(mukca_lcm_link_listen(link, all ? NULL : "A+B", &error), MUKCA_OK);
        while ((status = mukca_lcm_link_wait(link, 100, -1, NULL, &error)) == MUKCA_OK) continue;
        assert_int_equal(status, MUKCA_NEGATIVE);
        assert_int_equal(h.n, all ? 600 : 200);
        assert_int_equal(h.arm, all ? 400 : 0);
        assert_int_equal(h.last, all ? 1599 : 1597);
        assert_int_equal(mukca_lcm_link_clock(link), 1599);
        mukca_lcm_link_close(link);
    }
    heard h = {0};
    assert_int_equal(mukca_lcm_link_open(&link, &(mukca_lcm_network){.url = "file:///nowhere/x"},
                                         hear, &h, &error),
                     MUKCA_INPUT);
    assert_non_null(strstr(error.text, "/nowhere/x"));
    assert_int_equal(
        mukca_lcm_link_open(&link, &(mukca_lcm_network){.url = "tcpq://x"}, hear, &h, &error),
        MUKCA_USAGE);
}

static void count_note(void *context, const char *text)
{
    assert_non_null(strstr(text, "ends here"));
    ++*(int *)context;
}

/* A record that cannot be written any more is given up with one note; the stream goes on. */
TEST(full_disk_ends_the_record_only)
{
    mukca_lcm_link *link;
    mukca_error error = {0};
    heard h = {0};
    int notes = 0;
    char data[1000] = {0};
    struct rlimit old, small = {.rlim_cur = 20000};
    getrlimit(RLIMIT_FSIZE, &old);
    small.rlim_max = old.rlim_max;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(
        mukca_lcm_link_open(&link, &(mukca_lcm_network){.none = true}, hear, &h, &error), MUKCA_OK);
    assert_int_equal(mukca_lcm_link_listen(link, "ARM", &error), MUKCA_OK);
    assert_int_equal(mukca_lcm_link_record(link, path, true, count_note, &notes, &error), MUKCA_OK);
    setrlimit(RLIMIT_FSIZE, &small);
    for (int i = 0; i < 100; i++)
        assert_int_equal(mukca_lcm_link_publish(link, "ARM", data, sizeof data, &error), MUKCA_OK);
    setrlimit(RLIMIT_FSIZE, &old);
    signal(SIGXFSZ, SIG_DFL);
    assert_int_equal(notes, 1);
    mukca_lcm_link_close(link);
}

TEST_MAIN(setup, teardown)
