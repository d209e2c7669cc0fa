/* The machine is the host. */
#include <stdio.h>

#include "board.h"

void board_print(const char *text)
{
    fputs(text, stdout);
}

uint32_t board_clock(void)
{
    return 0;
}

double board_instructions(uint32_t since)
{
    return since;
}

double board_stack(void)
{
    return 0;
}
