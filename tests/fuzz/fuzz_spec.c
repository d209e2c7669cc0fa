/* Specifications of simulated effects: read or refused in one line, within the tables. */
#include <string.h>

#include "cli/simulate.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    static mukca_place places[2] = {{.name = "front"}, {.name = "a b"}};
    static cli_simulated simulated;
    mukca_error error = {MUKCA_OK, ""};
    char text[4096];
    if (size >= sizeof text || memchr(bytes, 0, size)) return 0;
    memcpy(text, bytes, size);
    text[size] = '\0';
    chain.n_elements = chain.n_joints = 2;
    for (int j = 0; j < 2; j++) {
        snprintf(chain.element[j].name, sizeof chain.element[j].name, "j%d", j + 1);
        chain.element[j].type = j ? MUKCA_PRISMATIC : MUKCA_REVOLUTE;
        chain.element[j].axis[2] = 1;
        chain.joint_element[j] = j;
    }
    memset(&simulated, 0, sizeof simulated);
    simulated.chain = &chain;
    simulated.places = places;
    simulated.n_places = 2;
    simulated.rows = 20;
    mukca_random_seed(&simulated.random, 1);
    for (int pass = 0; pass < 3; pass++) {
        if (cli_simulated_parse(&simulated, text, &error) &&
            (!error.text[0] || strchr(error.text, '\n')))
            abort();
        if (simulated.n_effects > MUKCA_MAX_EFFECTS ||
            simulated.n_faults > CLI_MAX_SIMULATED_FAULTS)
            abort();
    }
    return 0;
}
