/* Units in the names of columns. */
#include "base/cells.h"

#include <math.h>

#include <stddef.h>
#include <string.h>

#define DEGREE (M_PI / 180)

mukca_unit mukca_unit_take(char *name)
{
    static const struct {
        const char *name;
        mukca_unit unit;
    } units[] = {{"rad", {1, 'a'}},
                 {"deg", {DEGREE, 'a'}},
                 {"\xC2\xB0", {DEGREE, 'a'}},
                 {"\xB0", {DEGREE, 'a'}},
                 {"degrees", {DEGREE, 'a'}},
                 {"m", {1, 'l'}},
                 {"mm", {1e-3, 'l'}},
                 {"cm", {1e-2, 'l'}},
                 {"s", {1, 't'}},
                 {"ms", {1e-3, 't'}},
                 {"us", {1e-6, 't'}},
                 {"kg", {1, 'm'}},
                 {"N m", {1, 'N'}},
                 {"Nm", {1, 'N'}},
                 {"N*m", {1, 'N'}},
                 {"\302\260C", {1, 'C'}},
                 {"rad/s", {1, 'r'}},
                 {"deg/s", {DEGREE, 'r'}},
                 {"\xC2\xB0/s", {DEGREE, 'r'}}};
    size_t length = strlen(name);
    const char last = length ? name[length - 1] : '\0';
    char *open = last == ']' ? strrchr(name, '[') : last == ')' ? strrchr(name, '(') : NULL;
    if (!open || open == name) return (mukca_unit){0};
    length -= (size_t)(open - name) + 2;
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        if (strncmp(open + 1, units[i].name, length) != 0 || units[i].name[length]) continue;
        while (open > name && open[-1] == ' ') open--;
        *open = '\0';
        return units[i].unit;
    }
    return (mukca_unit){0};
}
