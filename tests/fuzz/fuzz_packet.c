/* Datagrams of LCM's UDP protocol: up to 255 bytes each, behind a byte of their length and one of
 * their sender; large messages only where that is 240 or more. */
#include "lcm/packet.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    mukca_lcm_reassembly r = {.dropped = 0};
    int64_t handled = 0, delivered = 0;
    while (size >= 2) {
        size_t length = bytes[0] < size - 2 ? bytes[0] : size - 2;
        unsigned char *copy = malloc(length ? length : 1); /* its end is guarded */
        if (!copy) abort();
        memcpy(copy, bytes + 2, length);
        if (length > 12 && bytes[1] < 240) copy[8] = copy[9] = 0; /* small messages are faster */
        mukca_lcm_packet packet = {
            .data = copy, .size = length, .sender = bytes[1] % 8, .time = handled++ * 20000};
        if (mukca_lcm_packet_take(&packet, &r)) {
            unsigned sum = 0;
            delivered++;
            if (!packet.channel[0] || strlen(packet.channel) >= MUKCA_LCM_CHANNEL_SIZE) abort();
            for (size_t i = 0; i < packet.size; i++) sum += ((const uint8_t *)packet.data)[i];
            if (sum > 255 * packet.size) abort();
        }
        free(copy);
        bytes += 2 + length;
        size -= 2 + length;
    }
    if (delivered > handled || r.dropped > 2 * handled) abort();
    mukca_lcm_packet_clear(&r);
    return 0;
}
