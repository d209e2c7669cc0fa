/* What the test image needs of the machine. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

void board_print(const char *text);

/* A clock, and the instructions since a time of it (0 on the host). */
uint32_t board_clock(void);
double board_instructions(uint32_t since);

/* Deepest stack so far, bytes (0 on the host). */
double board_stack(void);

#endif
