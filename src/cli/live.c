/* Options for other commands to read the arm and the session of a live recording. */
#include "cli/live.h"

#include <stdio.h>

void cli_live_arguments(cli_live_words *words, const cli_common *c, const cli_live *live)
{
    const double *g = c->gravity;
    const bool tilted = g[0] != 0 || g[1] != 0 || g[2] != 0;
    /* 15 digits reproduce the decimal input */
    snprintf(words->distance, sizeof words->distance, "%.15g", c->distance);
    snprintf(words->gravity, sizeof words->gravity, "%.15g,%.15g,%.15g", g[0], g[1], g[2]);
    const char *const options[][2] = {
        {"--urdf", c->urdf},
        {"--kinematics", c->kinematics},
        {"--base", c->base},
        {"--tip", c->tip},
        {"--inertials", c->inertials},
        {"--gravity", tilted ? words->gravity : NULL},
        {"--distance", c->distance != CLI_USUAL_DISTANCE ? words->distance : NULL},
        {"--distances", c->distances},
        {"--traits", live->traits}};
    int n = 0;
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++)
        for (int k = 0; k < 2 && options[i][1]; k++) words->word[n++] = options[i][k];
    words->word[n] = NULL;
}
