/* LCM: time to decode a message, and latency from a joint state to its pose.
 *
 *   bench_lcm decode        name, bytes, seconds per message, of three types
 *   bench_lcm pose RATE N   sends N joint states at RATE Hz to a running `mukca serve
 *                           --publish-pose`: quantiles of the seconds from sending a joint state
 *                           to receiving its pose */
#include <lcm/lcm.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "lcm/message.h"
#include "lcm/type.h"
#include "math/stats.h"

enum { JOINTS = 7, REPEATS = 200000 };

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- messages, encoded by hand ---- */

typedef struct {
    unsigned char bytes[2048];
    size_t n;
} message;

static void put(message *m, uint64_t value, int size)
{
    while (size--) m->bytes[m->n++] = (unsigned char)(value >> 8 * size);
}

static void put_reals(message *m, int n)
{
    for (int i = 0; i < n; i++) {
        double value = 0.01 * i;
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        put(m, bits, 8);
    }
}

static const char iiwa[] = "drake.lcmt_iiwa_status", panda[] = "drake.lcmt_panda_status",
                  named[] = "drake.lcmt_robot_state";

static void compose(message *m, const mukca_lcm_types *types, const char *name, uint64_t utime)
{
    m->n = 0;
    put(m, types->type[mukca_lcm_types_find_name(types, name)].fingerprint, 8);
    put(m, utime, 8);
    if (name == named) {
        put(m, JOINTS, 2);
        for (int j = 0; j < JOINTS; j++) put(m, 2, 4), put(m, 'a' << 8, 2);
        for (int j = 0; j < JOINTS; j++) put(m, 0, 4);
        return;
    }
    put(m, JOINTS, 4);
    put_reals(m, (name == panda ? 8 : 7) * JOINTS);
    if (name != panda) return;
    put_reals(m, 1);
    put(m, 1, 1);
    put(m, utime, 8);
    put(m, 1, 1);
}

static int bench_decode(const mukca_lcm_types *types)
{
    static const char *const kinds[] = {iiwa, panda, named};
    for (int k = 0; k < 3; k++) {
        static message m;
        static mukca_lcm_joints joints;
        mukca_error error;
        double best = 1;
        compose(&m, types, kinds[k], 1);
        for (int run = 0; run < 5; run++) {
            double start = now();
            for (int i = 0; i < REPEATS; i++) {
                m.bytes[15] = (unsigned char)i;
                int type = mukca_lcm_types_find(types, m.bytes, m.n);
                if (mukca_lcm_decode_joints(&joints, types, type, m.bytes, m.n, &error)) {
                    fprintf(stderr, "bench_lcm: %s\n", error.text);
                    return 1;
                }
            }
            double each = (now() - start) / REPEATS;
            if (each < best) best = each;
        }
        printf("%s %zu %.4g\n", kinds[k], m.n, best);
    }
    return 0;
}

/* ---- poses ---- */

typedef struct {
    int64_t wanted;
    double arrived; /* s; 0: not yet */
} waiter;

static void on_pose(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    waiter *w = context;
    mukca_message_pose pose;
    mukca_error error;
    (void)channel;
    if (!mukca_message_decode(&pose, MUKCA_MESSAGE_POSE, buffer->data, buffer->data_size, &error) &&
        pose.utime == w->wanted)
        w->arrived = now();
}

static int bench_pose(const mukca_lcm_types *types, double rate, int n)
{
    lcm_t *lcm = lcm_create(NULL);
    double *latency = calloc((size_t)n, sizeof *latency);
    if (!lcm || !latency) {
        fprintf(stderr, "bench_lcm: no LCM network\n");
        return 1;
    }
    waiter w = {.wanted = 0};
    lcm_subscribe(lcm, "MUKCA_POSE", on_pose, &w);
    static message m;
    int warm_up = (int)rate, good = 0, lost = 0;
    double due = now();
    for (int i = -warm_up; i < n; i++) {
        due += 1 / rate;
        while (now() < due) {
            struct timespec wait = {.tv_nsec = (long)(1e9 * (due - now() > 0 ? due - now() : 0))};
            nanosleep(&wait, NULL);
        }
        w.wanted = 1700000000000000 + (int64_t)(1e6 * (i + warm_up) / rate);
        w.arrived = 0;
        compose(&m, types, iiwa, (uint64_t)w.wanted);
        double sent = now();
        lcm_publish(lcm, "IIWA_STATUS", m.bytes, (unsigned)m.n);
        while (w.arrived == 0 && now() - sent < 0.1) lcm_handle_timeout(lcm, 5);
        if (i < 0) continue;
        if (w.arrived > 0)
            latency[good++] = w.arrived - sent;
        else
            lost++;
    }
    static const double share[] = {0.5, 0.99, 0.999, 1};
    printf("%d %d", good, lost);
    for (int k = 0; k < 4; k++) printf(" %.4g", mukca_stats_quantile(latency, good, share[k]));
    putchar('\n');
    free(latency);
    lcm_destroy(lcm);
    return good == 0;
}

int main(int argc, char **argv)
{
    static mukca_lcm_types types;
    mukca_error error;
    if (mukca_lcm_types_init(&types, &error)) return 1;
    if (argc == 2 && strcmp(argv[1], "decode") == 0) return bench_decode(&types);
    if (argc == 4 && strcmp(argv[1], "pose") == 0)
        return bench_pose(&types, atof(argv[2]), atoi(argv[3]));
    fprintf(stderr, "usage: bench_lcm decode | pose RATE N\n");
    return 2;
}
