/* Labels of a simulated recording, its hidden truth, as JSON. */
#include <math.h>

#include "cli/simulate.h"

static double size_of(const double *v, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum = hypot(sum, v[i]);
    return n == 1 ? v[0] : sum;
}

/* `row`: 1-based data row in the file. */
static json_t *fault_json(const mukca_simulated_fault *fault, const cli_simulation *s)
{
    static const char *const kinds[] = {[MUKCA_SIMULATED_STEP] = "tool_motion",
                                        [MUKCA_SIMULATED_CREEP] = "tool_motion",
                                        [MUKCA_SIMULATED_WRONG_SOCKET] = "wrong_socket",
                                        [MUKCA_SIMULATED_OUTLIER] = "outlier",
                                        [MUKCA_SIMULATED_DUPLICATE] = "duplicate"};
    const int before = (2 * fault->placement + fault->socket) * s->recording.rows;
    return json_pack("{s:s, s:s, s:s, s:i, s:b, s:f, s:o}", "kind", kinds[fault->kind], "placement",
                     s->places[fault->placement].name, "socket", fault->socket ? "1" : "0", "row",
                     before + fault->row + 1, "creep", (int)(fault->kind == MUKCA_SIMULATED_CREEP),
                     "size_m", size_of(fault->shift, 3), "shift_m",
                     cli_json_reals(fault->shift, 3));
}

static json_t *effect_json(const mukca_effect *effect, const cli_simulation *s)
{
    char variant[MUKCA_EFFECT_TEXT];
    mukca_effect_variant_text(variant, effect);
    return json_pack(
        "{s:s, s:o, s:o, s:o, s:s, s:f, s:s, s:o}", "effect",
        mukca_effect_table[effect->kind]->name, "joint",
        cli_json_text(mukca_chain_joint_name(&s->model.chain, effect->joint)), "placement",
        cli_json_text(effect->placement < 0 ? NULL : s->places[effect->placement].name), "order",
        effect->variant.order ? json_integer(effect->variant.order) : json_null(), "variant",
        variant, "amplitude", size_of(effect->coefficient, effect->terms), "unit",
        mukca_effect_unit(effect, &s->model.chain), "coefficients",
        cli_json_reals(effect->coefficient, effect->terms));
}

mukca_status cli_write_labels(cli_call *call, const cli_simulation *s, const mukca_dataset *data)
{
    const cli_simulate_options *o = call->options;
    json_t *effects = json_array(), *faults = json_array();
    for (int i = 0; i < s->arm.n_effects; i++)
        json_array_append_new(effects, effect_json(&s->arm.effects[i], s));
    for (int i = 0; i < s->hidden.n_faults; i++)
        json_array_append_new(faults, fault_json(&s->hidden.faults[i], s));
    json_t *root = json_pack(
        "{s:s, s:i, s:i, s:f, s:f, s:o, s:o, s:o}", "schema", "mukca.simulation/1", "seed", o->seed,
        "rows", data->n_rows, "noise_m", o->noise, "correlation", o->correlation, "effects",
        effects, "data_faults", faults, "parameters", cli_json_offsets(&s->truth, &s->model.chain));
    return cli_write_json_to(call, o->labels, root);
}
