/* Specifications of simulated effects: read or refused in one line, within the tables. */
#include "../unit/arms.h"
#include "cli/simulate.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    static mukca_place places[2] = {{.name = "front"}, {.name = "a b"}};
    static cli_simulated simulated;
    mukca_error error = {MUKCA_OK, ""};
    if (size >= 4096 || memchr(bytes, 0, size)) return 0;
    char *text = as_text(bytes, size);
    make_chain(&chain, "RP", NULL, "j", 3);
    memset(&simulated, 0, sizeof simulated);
    simulated.chain = &chain;
    simulated.places = places;
    simulated.n_places = 2;
    simulated.rows = 20;
    simulated.random = mukca_random_seeded(1);
    for (int pass = 0; pass < 4; pass++) {
        simulated.moves = pass == 3;
        check_refusal(cli_simulated_parse(&simulated, text, &error), &error);
        if (simulated.n_effects > MUKCA_MAX_EFFECTS ||
            simulated.n_faults > CLI_MAX_SIMULATED_FAULTS ||
            simulated.n_torques > CLI_MAX_SIMULATED_TORQUES)
            abort();
    }
    free(text);
    return 0;
}
