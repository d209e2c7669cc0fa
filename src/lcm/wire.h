/* Big-endian numbers and texts of LCM messages and event logs, with bounds checks. */
#ifndef MUKCA_LCM_WIRE_H
#define MUKCA_LCM_WIRE_H

#include <stddef.h>
#include <stdint.h>

/* The unread rest of a message. */
typedef struct {
    const unsigned char *at;
    size_t left; /* bytes */
} mukca_lcm_wire;

/* Read, or write, an unsigned number of 1 to 8 bytes at `at`. */
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

/* Read the next n bytes; NULL: fewer are left. */
static inline const unsigned char *mukca_lcm_wire_bytes(mukca_lcm_wire *wire, size_t n)
{
    const unsigned char *at = wire->at;
    if (n > wire->left) return NULL;
    wire->at += n;
    wire->left -= n;
    return at;
}

/* Read the next text: 4 bytes of length, including the NUL, then the characters.  The result points
 * into the message; NULL: truncated, or not NUL-terminated. */
static inline const char *mukca_lcm_wire_text(mukca_lcm_wire *wire)
{
    const unsigned char *head = mukca_lcm_wire_bytes(wire, 4);
    uint64_t length = head ? mukca_lcm_wire_get(head, 4) : 0;
    const unsigned char *text = length ? mukca_lcm_wire_bytes(wire, length) : NULL;
    return text && text[length - 1] == '\0' ? (const char *)text : NULL;
}

#endif
