/* `mukca serve --publish-pose` allocates nothing per message: a long log costs as many calls of the
 * allocator as a short one. */
#include <lcm/lcm.h>

#include "cli/cli.h"
#include "io/urdf.h"
#include "lcm/packet.h"
#include "noalloc.h"
#include "scratch.h"

static char urdf[] = "data/demo/arm.urdf";

/* A calibration (of a kind) for the server to use. */
static void write_model(void)
{
    static mukca_chain chain;
    static mukca_offsets offsets;
    mukca_urdf_options options = {.tip = NULL};
    assert_ok(mukca_urdf_load(&chain, urdf, &options, &error));
    mukca_offsets_init(&offsets, &chain);
    for (int i = 0; i < 6 * chain.n_elements; i++) offsets.theta[i] += 1e-3;
    memset(offsets.listed, 1, 6 * (size_t)chain.n_elements);
    offsets.acceptance.given = offsets.acceptance.accepted = offsets.acceptance.converged = true;
    offsets.acceptance.error_nominal_m = 1e-3;
    offsets.acceptance.error_m = 1e-4;
    const char *path;
    FILE *file = scratch_create(&path, "in_use.tsv");
    assert_ok(mukca_offsets_write(file, &offsets, &chain, NULL, NULL, &error));
    fclose(file);
    scratch_file("state.tsv", "model\tx.offsets.tsv\nmodel_stream\traw\n");
}

/* n joint states of an iiwa at 1 kHz. */
static void write_log(int n)
{
    char channel[] = "IIWA_STATUS";
    lcm_eventlog_t *log = lcm_eventlog_create(scratch_file("in", ""), "w");
    assert_non_null(log);
    for (int i = 0; i < n; i++) {
        unsigned char bytes[20 + 56 * 7];
        uint64_t time = 1700000000000000 + 1000 * (uint64_t)i;
        mukca_lcm_wire_put(bytes, 0xf16fb804284abca3 /* drake.lcmt_iiwa_status */, 8);
        mukca_lcm_wire_put(bytes + 8, time, 8);
        mukca_lcm_wire_put(bytes + 16, 7, 4);
        for (int k = 0; k < 49; k++) {
            double q = 0.01 * k + 1e-4 * i;
            uint64_t bits;
            memcpy(&bits, &q, sizeof bits);
            mukca_lcm_wire_put(bytes + 20 + 8 * k, bits, 8);
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
    const char *out = scratch_file("out", "");
    char line[600], *argv[20];
    snprintf(line, sizeof line,
             "--urdf %s --lcm-url file://%s/in --channel IIWA_STATUS --map order --state %s "
             "--publish-pose --force",
             urdf, scratch_folder, scratch_folder);
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
    long few, many;
    write_model();
    write_log(1000);
    assert_int_equal(serve(&few), 1000);
    write_log(30000);
    assert_int_equal(serve(&many), 30000);
    assert_true(few > 0);
    assert_int_equal(many, few);
}

TEST_MAIN(scratch_setup, scratch_teardown)
