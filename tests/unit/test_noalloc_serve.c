/* `mukca serve --publish-pose` allocates nothing per message: a long log costs as many calls of the
 * allocator as a short one. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <lcm/lcm.h>

#include "cli/cli.h"
#include "io/urdf.h"
#include "noalloc.h"
#include "scratch.h"

static char folder[] = "/tmp/mukca_test_serve_XXXXXX";
static char urdf[] = "data/demo/arm.urdf";

static void path_of(char path[128], const char *name)
{
    snprintf(path, 128, "%s/%s", folder, name);
}

static FILE *create(const char *name)
{
    char path[128];
    path_of(path, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    return file;
}

/* A calibration (of a kind) for the server to use. */
static void write_model(void)
{
    static mukca_chain chain;
    static mukca_offsets offsets;
    mukca_urdf_options options = {.tip = NULL};
    assert_ok(mukca_urdf_load(&chain, urdf, &options, NULL, NULL, &error));
    mukca_offsets_init(&offsets, &chain);
    for (int i = 0; i < 6 * chain.n_elements; i++) offsets.theta[i] += 1e-3;
    memset(offsets.listed, 1, 6 * (size_t)chain.n_elements);
    offsets.acceptance.given = offsets.acceptance.accepted = offsets.acceptance.converged = true;
    offsets.acceptance.error_nominal_m = 1e-3;
    offsets.acceptance.error_m = 1e-4;
    FILE *file = create("in_use.tsv");
    assert_ok(mukca_offsets_write(file, &offsets, &chain, NULL, NULL, &error));
    fclose(file);
    file = create("state.tsv");
    fputs("model\tx.offsets.tsv\nmodel_stream\traw\n", file);
    fclose(file);
}

static void put(unsigned char *bytes, size_t *at, uint64_t value, int size)
{
    while (size--) bytes[(*at)++] = (unsigned char)(value >> 8 * size);
}

/* n joint states of an iiwa at 1 kHz. */
static void write_log(int n)
{
    char path[128], channel[] = "IIWA_STATUS";
    path_of(path, "in");
    lcm_eventlog_t *log = lcm_eventlog_create(path, "w");
    assert_non_null(log);
    for (int i = 0; i < n; i++) {
        unsigned char bytes[20 + 56 * 7];
        size_t at = 0;
        uint64_t time = 1700000000000000 + 1000 * (uint64_t)i;
        put(bytes, &at, 0xf16fb804284abca3 /* drake.lcmt_iiwa_status */, 8);
        put(bytes, &at, time, 8);
        put(bytes, &at, 7, 4);
        for (int k = 0; k < 49; k++) {
            double q = 0.01 * k + 1e-4 * i;
            uint64_t bits;
            memcpy(&bits, &q, sizeof bits);
            put(bytes, &at, bits, 8);
        }
        lcm_eventlog_event_t event = {.timestamp = (int64_t)time,
                                      .channellen = (int32_t)strlen(channel),
                                      .datalen = sizeof bytes,
                                      .channel = channel,
                                      .data = bytes};
        assert_int_equal(lcm_eventlog_write_event(log, &event), 0);
    }
    lcm_eventlog_destroy(log);
}

/* Run the command on the log; poses sent, and calls of the allocator. */
static int serve(long *used)
{
    char in[128], out[128];
    path_of(in, "in");
    path_of(out, "out");
    char line[600];
    snprintf(line, sizeof line,
             "--urdf %s --lcm-url file://%s --channel IIWA_STATUS --map order --state %s "
             "--publish-pose --force",
             urdf, in, folder);
    char *argv[20];
    int argc = 0;
    for (char *word = strtok(line, " "); word; word = strtok(NULL, " ")) argv[argc++] = word;
    cli_call call = {.command = cli_find_command("serve")};
    bool help;
    assert_ok(cli_parse(&call, &help, argc, argv));
    assert_non_null(freopen(out, "w", stderr));
    long before = calls;
    if (cli_run(&call)) fail_msg("%s", call.error.text);
    *used = calls - before;
    fflush(stderr);
    cli_call_free(&call);
    int poses = 0;
    char *said = scratch_read(out), *sent = strstr(said, " poses sent");
    while (sent && sent > said && sent[-1] != '\n') sent--;
    if (sent) poses = atoi(sent);
    free(said);
    return poses;
}

TEST(poses_cost_no_allocation)
{
    static const char *const folders[] = {"results", "sessions"};
    long few, many;
    assert_non_null(mkdtemp(folder));
    for (int i = 0; i < 2; i++) {
        char path[128];
        path_of(path, folders[i]);
        assert_int_equal(mkdir(path, 0777), 0);
    }
    write_model();
    write_log(1000);
    assert_int_equal(serve(&few), 1000);
    write_log(30000);
    assert_int_equal(serve(&many), 30000);
    assert_true(few > 0);
    assert_int_equal(many, few);
    static const char *const names[] = {"in", "out", "lock", "state.tsv", "in_use.tsv"};
    for (int i = 0; i < 7; i++) {
        char path[128];
        path_of(path, i < 5 ? names[i] : folders[i - 5]);
        assert_int_equal(remove(path), 0);
    }
    rmdir(folder);
}

TEST_MAIN(NULL, NULL)
