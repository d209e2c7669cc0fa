/* Units in the names of columns. */
#include "base/cells.h"

#include <math.h>

#include <stddef.h>
#include <string.h>

#define DEGREE (M_PI / 180)

double mukca_unit_take(char *name)
{
    static const struct {
        const char *unit;
        double factor;
    } units[] = {{"rad", 1},
                 {"deg", DEGREE},
                 {"\xC2\xB0", DEGREE},
                 {"\xB0", DEGREE},
                 {"degrees", DEGREE},
                 {"m", 1},
                 {"mm", 1e-3},
                 {"cm", 1e-2},
                 {"s", 1},
                 {"ms", 1e-3},
                 {"us", 1e-6},
                 {"kg", 1},
                 {"N m", 1},
                 {"Nm", 1},
                 {"N*m", 1},
                 {"\xC2\xB0"
                  "C",
                  1},
                 {"rad/s", 1},
                 {"deg/s", DEGREE},
                 {"\xC2\xB0/s", DEGREE}};
    size_t length = strlen(name);
    const char last = length ? name[length - 1] : '\0';
    char *open = last == ']' ? strrchr(name, '[') : last == ')' ? strrchr(name, '(') : NULL;
    if (!open || open == name) return 0;
    length -= (size_t)(open - name) + 2;
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        if (strncmp(open + 1, units[i].unit, length) != 0 || units[i].unit[length]) continue;
        while (open > name && open[-1] == ' ') open--;
        *open = '\0';
        return units[i].factor;
    }
    return 0;
}
