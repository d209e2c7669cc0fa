/* A bare Cortex-M7 as in qemu's mps2-an500: vectors, start, semihosting, instruction counter. */
#include "board.h"

/* With -icount shift=0 an instruction takes 1 ns, a tick of the 25 MHz SysTick so 40 of them. */
enum { INSTRUCTIONS_PER_TICK = 40, TICKS = 0xFFFFFF };

static volatile uint32_t *const systick = (volatile uint32_t *)0xE000E010; /* CSR, RVR, CVR */
static volatile uint32_t *const cpacr = (volatile uint32_t *)0xE000ED88;

extern uint32_t data_start[], data_end[], data_load[], bss_start[], bss_end[], stack_low[],
    stack_top[];
int main(void);
void reset(void);

static const uint32_t pattern = 0xA5A5A5A5;

static int semihost(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void board_print(const char *text)
{
    semihost(0x04, text); /* SYS_WRITE0 */
}

uint32_t board_clock(void)
{
    return systick[2];
}

double board_instructions(uint32_t since)
{
    return (double)INSTRUCTIONS_PER_TICK * ((since - systick[2]) & TICKS); /* it counts down */
}

double board_stack(void)
{
    const uint32_t *p = stack_low;
    while (*p == pattern) p++;
    return 4.0 * (double)(stack_top - p);
}

/* libm's errno, which nothing reads.  newlib's own is in a structure of 1 KB for its stdio. */
int *__errno(void);
int *__errno(void)
{
    static int number;
    return &number;
}

/* A fault, or the end: the exit code goes to qemu. */
static void leave(uint32_t code)
{
    const uint32_t block[2] = {0x20026, code}; /* ADP_Stopped_ApplicationExit */
    for (;;) semihost(0x20, block);            /* SYS_EXIT_EXTENDED */
}

static void fault(void)
{
    board_print("fault\n");
    leave(3);
}

void reset(void)
{
    const uint32_t *const here = __builtin_frame_address(0);
    for (uint32_t *p = stack_low; p < here - 16; p++) *p = pattern;
    for (uint32_t *from = data_load, *to = data_start; to < data_end;) *to++ = *from++;
    for (uint32_t *p = bss_start; p < bss_end;) *p++ = 0;
    *cpacr |= 0xFU << 20; /* the FPU */
    __asm__ volatile("dsb\nisb");
    systick[1] = TICKS;
    systick[2] = 0;
    systick[0] = 5; /* on, processor clock, no interrupt */
    leave((uint32_t)main());
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    stack_top,           (const void *)reset, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault, (const void *)fault};
