/* The table of built-in types of joint states. */
#include "lcm/state.h"

#include <string.h>

#include "lcm/description.h"

static const mukca_lcm_state *const states[] = {
#define STATE(name, type, channel, fingerprint) &mukca_lcm_state_##name,
    MUKCA_LCM_STATE_LIST(STATE)
#undef STATE
};

mukca_status mukca_lcm_types_init(mukca_lcm_types *types, mukca_error *error)
{
    types->n_types = types->n_fields = 0;
    for (int i = 0; i < MUKCA_LCM_STATES; i++) {
        const mukca_lcm_state *state = states[i];
        mukca_status status = mukca_lcm_types_parse(
            types, state->description, strlen(state->description), "the built-in table", error);
        for (int r = 0; r < MUKCA_LCM_ROLES && !status; r++)
            if (state->role[r])
                status =
                    mukca_lcm_type_set_role(types, i, (mukca_lcm_role)r, state->role[r], error);
        if (status != MUKCA_OK) return status;
        if (state->effort_factor != 0) types->type[i].effort_factor = state->effort_factor;
        types->type[i].guiding_mode = state->guiding_mode;
    }
    return MUKCA_OK;
}
