/* Pose and Jacobian of a compiled-in offsets table for 1000 configurations, as hexadecimal numbers:
 * on a bare Cortex-M7 (board.c) and, for comparison, on the host. */
#include <stdint.h>
#include <string.h>

#include "board.h"
#include "mukca/corrected.h"
#include HEADER /* mukca export -f c: heron7_arm */

enum { CONFIGURATIONS = 1000, JOINTS = 7 };

__asm__(
    ".section .table, \"a\"\n"
    "table_start:\n"
    ".incbin \"" TABLE
    "\"\n"
    "table_end:\n"
    ".previous\n");
extern const char table_start[], table_end[];

static mukca_corrected arm;

/* In [-1, 1), the same on all machines (Knuth's MMIX generator). */
static double draw(void)
{
    static uint64_t state = 1;
    state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(int32_t)(state >> 32) / 2147483648.0;
}

static void print(const char *label, const double *values, int n)
{
    for (int i = 0; i < n; i++) {
        char text[20];
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        for (int digit = 0; digit < 16; digit++)
            text[digit] = "0123456789abcdef"[bits >> (60 - 4 * digit) & 15];
        text[16] = i + 1 < n ? ' ' : '\n';
        text[17] = '\0';
        if (i == 0) board_print(label);
        board_print(text);
    }
}

typedef enum { POSITION, POSE, JACOBIAN, CALLS } call;

/* Instructions of a call, the most and the mean so far. */
static void count(double most[CALLS], double sum[CALLS], call which, uint32_t before)
{
    const double n = board_instructions(before);
    if (n > most[which]) most[which] = n;
    sum[which] += n / CONFIGURATIONS;
}

/* The header's arm against the table's, in all bits. */
static bool differs(const mukca_frame *tip, const double *J, const double *q,
                    const mukca_joint_state *state)
{
    static double header_J[6 * JOINTS];
    mukca_frame header_tip;
    mukca_corrected_pose(&header_tip, &heron7_arm, q, state);
    mukca_corrected_jacobian(header_J, NULL, &heron7_arm, q, state);
    return memcmp(header_J, J, sizeof header_J) != 0 || memcmp(&header_tip, tip, sizeof *tip) != 0;
}

int main(void)
{
    static mukca_error error;
    double most[CALLS] = {0}, mean[CALLS] = {0}, parse;
    uint32_t before = board_clock();
    if (mukca_corrected_parse(&arm, table_start, (size_t)(table_end - table_start), &error)) {
        board_print(error.text);
        return 1;
    }
    parse = board_instructions(before);
    for (int i = 0; i < CONFIGURATIONS; i++) {
        static double q[JOINTS], move[JOINTS], command[JOINTS], position[3], J[6 * JOINTS];
        mukca_frame tip;
        for (int j = 0; j < JOINTS; j++) {
            q[j] = 3 * draw();
            move[j] = 0.1 * draw();
            command[j] = q[j] + 1e-3 * draw();
        }
        const mukca_joint_state state = {.move = move,
                                         .command = command,
                                         .time = 1800 + 1800 * draw(),
                                         .payload_kg = 1 + draw(),
                                         .placement = i % 3};
        before = board_clock();
        mukca_corrected_position(position, &arm, q, &state);
        count(most, mean, POSITION, before);
        before = board_clock();
        mukca_corrected_pose(&tip, &arm, q, &state);
        count(most, mean, POSE, before);
        before = board_clock();
        mukca_corrected_jacobian(J, NULL, &arm, q, &state);
        count(most, mean, JACOBIAN, before);
        if (differs(&tip, J, q, &state)) {
            board_print("the arm of the exported header differs from that of the table\n");
            return 2;
        }
        print("position ", position, 3);
        print("rotation ", tip.R, 9);
        print("translation ", tip.p, 3);
        print("jacobian ", J, 6 * JOINTS);
    }
    const double effects = arm.n_effects, stack = board_stack(), ram = sizeof arm;
    print("effects ", &effects, 1);
    print("model ", &ram, 1);
    print("stack ", &stack, 1);
    print("parse ", &parse, 1);
    print("most ", most, CALLS);
    print("mean ", mean, CALLS);
    return 0;
}
