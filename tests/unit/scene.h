/* A simulated arm at four placements: the demo arm with errors, and what --effect may add. */
#ifndef MUKCA_TESTS_SCENE_H
#define MUKCA_TESTS_SCENE_H

#include "cli/simulate.h"
#include "close.h"
#include "io/urdf.h"

enum { PLACES = 4 };

/* An arm with 1 mm and 2 mrad of errors and the effects and faults of `text` (may be NULL). */
typedef struct {
    mukca_chain chain;
    mukca_corrected arm;
    cli_simulated hidden;
    mukca_place places[PLACES];
    mukca_simulate_options how;
} scene;

static inline void set_scene(scene *s, const char *text, uint64_t seed)
{
    static const char *const names[PLACES] = {"front", "left", "right", "high"};
    double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    memset(s, 0, sizeof *s);
    assert_ok(mukca_urdf_load(&s->chain, "data/demo/arm.urdf", NULL, &error));
    s->how = (mukca_simulate_options){.rows = 30, .distance = 0.05, .seed = seed};
    mukca_chain_theta(theta, &s->chain);
    mukca_simulate_perturb(theta, NULL, &s->chain, 1e-3, 2e-3, seed);
    mukca_simulate_arm(&s->arm, &s->chain, theta);
    for (int p = 0; p < PLACES; p++)
        snprintf(s->places[p].name, sizeof s->places[p].name, "%s", names[p]);
    assert_ok(mukca_simulate_places(s->places, PLACES, &s->chain, 0.05, seed, &error));
    s->hidden = (cli_simulated){
        .chain = &s->chain, .places = s->places, .n_places = PLACES, .rows = s->how.rows};
    mukca_simulate_seed(&s->hidden.random, seed, MUKCA_DRAW_EFFECTS);
    if (text && cli_simulated_parse(&s->hidden, text, &error)) fail_msg("%s", error.text);
    memcpy(s->arm.effects, s->hidden.effects, sizeof s->arm.effects);
    s->arm.n_effects = s->hidden.n_effects;
}

/* At the first n places. */
static inline void record_at(mukca_dataset *data, const scene *s, int n)
{
    const mukca_simulated_session session = {.arm = &s->arm,
                                             .places = s->places,
                                             .n_places = n,
                                             .faults = s->hidden.faults,
                                             .n_faults = s->hidden.n_faults,
                                             .options = &s->how};
    assert_ok(mukca_simulate_sockets(data, &session, &error));
}

static inline void record(mukca_dataset *data, const scene *s)
{
    record_at(data, s, PLACES);
}

#endif
