/* Numbers: what is taken for one is what the C library reads, up to the last bit of long ones. */
#include "base/number.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    char text[128], *end;
    double ours, list[3];
    if (size >= sizeof text) return 0;
    memcpy(text, bytes, size);
    text[size] = '\0';
    mukca_number_parse_list(list, 3, text);
    if (!mukca_number_parse(&ours, text)) return 0;
    double theirs = strtod(text, &end);
    if (*end || !isfinite(ours) || !(ours >= nextafter(theirs, -HUGE_VAL)) ||
        !(ours <= nextafter(theirs, HUGE_VAL)) || signbit(ours) != signbit(theirs))
        abort();
    return 0;
}
