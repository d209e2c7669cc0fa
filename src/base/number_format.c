/* Conversion of numbers to text. */
#include <stdio.h>

#include "base/number.h"

void mukca_number_format(char text[MUKCA_NUMBER_SIZE], double value)
{
    for (int digits = 15; digits <= 17; digits++) {
        double back;
        snprintf(text, MUKCA_NUMBER_SIZE, "%.*g", digits, value + 0.0); /* -0 + 0 is 0 */
        if (mukca_number_parse(&back, text) && !(back < value) && !(back > value)) return;
    }
}
