/* Big-endian numbers and texts of LCM messages and event logs, read within bounds. */
#ifndef MUKCA_LCM_WIRE_H
#define MUKCA_LCM_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* What is left to read. */
typedef struct {
    const unsigned char *at;
    size_t left; /* bytes */
} mukca_lcm_wire;

/* The unsigned number in at[size], 1 to 8 bytes; and the way back. */
static inline uint64_t mukca_lcm_wire_get(const unsigned char *at, int size)
{
    uint64_t value = 0;
    for (int i = 0; i < size; i++) value = value << 8 | at[i];
    return value;
}

static inline void mukca_lcm_wire_put(unsigned char *at, uint64_t value, int size)
{
    for (int i = 0; i < size; i++) at[i] = (unsigned char)(value >> 8 * (size - 1 - i));
}

/* The next n bytes; NULL where fewer are left. */
static inline const unsigned char *mukca_lcm_wire_bytes(mukca_lcm_wire *wire, size_t n)
{
    const unsigned char *at = wire->at;
    if (n > wire->left) return NULL;
    wire->at += n;
    wire->left -= n;
    return at;
}

/* The next text: its length with the NUL in 4 bytes, then the characters.  It points into the
 * message.  NULL where it does not fit or has no NUL at its end. */
static inline const char *mukca_lcm_wire_text(mukca_lcm_wire *wire)
{
    const unsigned char *head = mukca_lcm_wire_bytes(wire, 4);
    uint64_t length = head ? mukca_lcm_wire_get(head, 4) : 0;
    const unsigned char *text = length ? mukca_lcm_wire_bytes(wire, length) : NULL;
    return text && text[length - 1] == '\0' ? (const char *)text : NULL;
}

#endif
