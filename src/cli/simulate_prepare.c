/* Preparation of `mukca simulate`: true arm and recording from the options. */
#include <string.h>

#include "base/number.h"
#include "cli/simulate.h"
#include "io/output.h"

/* True for a pose log instead of sockets. */
static bool is_log(const cli_simulate_options *o)
{
    return o->poses || o->at;
}

static mukca_status check(const cli_simulate_options *o, mukca_error *error)
{
    if ((o->held_out > 0) != (o->test != NULL))
        return mukca_fail(error, MUKCA_USAGE, "--held-out N and --test FILE go together");
    if (o->at && (o->poses || o->held_out || o->sweep))
        return mukca_fail(error, MUKCA_USAGE,
                          "--at sets the postures; omit --poses, --sweep and --held-out");
    if (is_log(o) && (o->places.n || o->placements))
        return mukca_fail(error, MUKCA_USAGE, "a pose log has no placements");
    if (!is_log(o) && (o->position_only || o->rotation > 0))
        return mukca_fail(error, MUKCA_USAGE,
                          "--position-only and --rotation-noise are for pose logs (--poses, --at)");
    if (o->common.distance > 1)
        return mukca_fail(error, MUKCA_USAGE, "--distance %g looks like millimetres; give m",
                          o->common.distance);
    return MUKCA_OK;
}

/* Read comma-separated numbers.  Returns how many, -1: an invalid one, or more than `most`. */
static int read_list(double *values, int most, const char *text)
{
    char number[64];
    int n = 0;
    for (;; text++) {
        const size_t length = strcspn(text, ",");
        if (n == most || length >= sizeof number) return -1;
        memcpy(number, text, length);
        number[length] = '\0';
        if (!mukca_number_parse(&values[n++], number)) return -1;
        text += length;
        if (!*text) return n;
    }
}

mukca_status cli_read_place(mukca_place *place, const char *text, mukca_error *error)
{
    double v[6] = {0};
    const size_t length = strcspn(text, "=");
    if (length == 0 || length >= sizeof place->name || strcspn(text, "\t,#/ ") < length)
        return mukca_fail(error, MUKCA_USAGE, "--place %.80s: begins with no usable name", text);
    memcpy(place->name, text, length);
    if (!text[length]) return MUKCA_OK;
    const int n = read_list(v, 6, text + length + 1);
    if (n != 3 && n != 6)
        return mukca_fail(error, MUKCA_USAGE,
                          "--place %.80s: needs NAME=X,Y,Z or NAME=X,Y,Z,ROLL,PITCH,YAW", text);
    memcpy(place->pose.p, v, sizeof place->pose.p);
    mukca_rotation_from_rpy(place->pose.R, v + 3);
    place->placed = true;
    return MUKCA_OK;
}

/* All placements: those of the session, then the held-out ones. */
static mukca_status name_places(cli_simulation *s, const cli_simulate_options *o,
                                mukca_error *error)
{
    const int held_out = is_log(o) ? 0 : o->held_out;
    const int n = is_log(o) ? 0 : o->placements ? o->placements : o->places.n ? o->places.n : 4;
    if (n < o->places.n || n >= CLI_MAX_PLACES || held_out > CLI_MAX_PLACES - n)
        return mukca_fail(error, MUKCA_USAGE,
                          "--placements %d: must be at most %d with --held-out, and not below the "
                          "number of --place",
                          n, CLI_MAX_PLACES);
    s->n_places = n;
    for (int i = 0; i < n + held_out; i++) {
        mukca_place *p = &s->places[i];
        mukca_status status = MUKCA_OK;
        if (i < o->places.n)
            status = cli_read_place(p, o->places.items[i], error);
        else
            snprintf(p->name, sizeof p->name, i < n ? "p%d" : "held_out_%d",
                     i < n ? i + 1 : i - n + 1);
        for (int k = 0; k < i && status == MUKCA_OK; k++)
            if (strcmp(s->places[k].name, p->name) == 0)
                status =
                    mukca_fail(error, MUKCA_USAGE, "two placements have the name '%s'", p->name);
        if (status) return status;
    }
    return mukca_simulate_places(s->places, n + held_out, &s->model.chain, s->recording.distance,
                                 s->recording.seed, error);
}

/* Gather the effects of --offsets, then those of --effect. */
static mukca_status gather_effects(cli_simulation *s, const cli_simulate_options *o,
                                   mukca_error *error)
{
    cli_simulated *hidden = &s->hidden;
    const mukca_offsets *given = &s->model.offsets;
    hidden->chain = &s->model.chain;
    hidden->places = s->places;
    hidden->n_places = s->n_places;
    hidden->rows = o->rows;
    mukca_simulate_seed(&hidden->random, s->recording.seed, MUKCA_DRAW_EFFECTS);
    for (int e = 0; e < given->n_effects; e++) {
        mukca_effect effect = given->effects[e];
        const char *name = effect.placement >= 0 ? given->placements[effect.placement] : NULL;
        effect.placement = -1;
        for (int p = 0; p < s->n_places && name; p++)
            if (strcmp(s->places[p].name, name) == 0) effect.placement = p;
        if (!name || effect.placement >= 0) hidden->effects[hidden->n_effects++] = effect;
    }
    for (int i = 0; i < o->effects.n; i++) {
        mukca_status status = cli_simulated_parse(hidden, o->effects.items[i], error);
        if (status) return status;
    }
    memcpy(s->arm.effects, hidden->effects, sizeof hidden->effects);
    s->arm.n_effects = hidden->n_effects;
    return MUKCA_OK;
}

/* The true arm as an offsets table, without recording faults. */
static void set_truth(cli_simulation *s)
{
    for (int p = 0; p < s->n_places; p++)
        memcpy(s->truth.placements[p], s->places[p].name, MUKCA_NAME_SIZE);
    s->truth.n_placements = s->n_places;
    s->truth.n_effects = 0;
    for (int e = 0; e < s->arm.n_effects; e++)
        if (!mukca_effect_has((int)s->arm.effects[e].kind, MUKCA_TRAIT_RECORDING_FAULT))
            s->truth.effects[s->truth.n_effects++] = s->arm.effects[e];
}

mukca_status cli_simulation_prepare(cli_call *call, cli_simulation *s)
{
    const cli_simulate_options *o = call->options;
    double perturb[2] = {0, 0};
    mukca_status status = check(o, &call->error);
    if (status == MUKCA_OK && o->perturb && read_list(perturb, 2, o->perturb) != 2)
        status = mukca_fail(&call->error, MUKCA_USAGE,
                            "--perturb %.40s: must be MM,MRAD, two numbers", o->perturb);
    const char *const files[] = {call->common->output, o->test, o->truth};
    for (int i = 0; i < 3 && status == MUKCA_OK; i++) {
        if (!files[i]) continue;
        for (int k = 0; k < i && status == MUKCA_OK; k++)
            if (mukca_output_same(files[i], files[k]))
                status = mukca_fail(&call->error, MUKCA_USAGE, "two outputs cannot both go to %s",
                                    files[i]);
        if (status == MUKCA_OK) status = cli_keep_inputs(call, files[i]);
        if (status == MUKCA_OK)
            status = mukca_output_check(files[i], call->common->force, &call->error);
    }
    call->common->accept_failed = call->common->accept_edited = true; /* the true arm may be any */
    if (status == MUKCA_OK) status = cli_load_model(call, &s->model);
    if (status) return status;
    s->recording = (mukca_simulate_options){.rows = o->rows,
                                            .distance = call->common->distance,
                                            .noise = o->noise,
                                            .rotation = o->rotation,
                                            .correlation = o->correlation,
                                            .sweep = o->sweep,
                                            .effort = o->effort,
                                            .command = o->command,
                                            .position_only = o->position_only,
                                            .payload = o->payload,
                                            .seed = (uint64_t)o->seed,
                                            .interrupted = cli_interrupted};
    if (s->recording.effort && !s->model.chain.n_masses)
        return mukca_fail(&call->error, MUKCA_USAGE,
                          "--effort needs link masses; give --inertials FILE");
    s->truth = s->model.offsets;
    mukca_simulate_perturb(s->truth.theta, o->perturb ? s->truth.listed : NULL, &s->model.chain,
                           1e-3 * perturb[0], 1e-3 * perturb[1], s->recording.seed);
    for (int i = 0; i < MUKCA_MAX_THETA; i++) s->truth.identifiable[i] = s->truth.listed[i];
    mukca_simulate_arm(&s->arm, &s->model.chain, s->truth.theta, 0, s->recording.seed);
    status = name_places(s, o, &call->error);
    if (status == MUKCA_OK) status = gather_effects(s, o, &call->error);
    if (status == MUKCA_OK) set_truth(s);
    return status;
}
