/* Value of planned postures on simulated arms: `make -f tools/Makefile verify-plan`.
 *
 *   bench_plan accuracy ARMS: held-out error after 20 planned rows per socket beside 40 random ones
 *
 *   bench_plan ties TIES: how often 10 planned rows turn a tied diagnosis of a session of random
 *   postures into the right name, beside 10 random ones
 *
 * The truth (origins, effects, noise) is drawn from seeds; in a planned row the true arm, moved to
 * the proposed joint angles, seats its ball in the true socket.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arm/inverse.h"
#include "diagnose/diagnose.h"
#include "diagnose/next_poses.h"
#include "fit/evaluate.h"
#include "fit/fit.h"
#include "io/urdf.h"
#include "plan/plan.h"
#include "simulate/simulate.h"

enum { PLACES = 5, RANDOM_ROWS = 40, PLANNED_ROWS = 20, TIE_ROWS = 10 };
static const double noise = 1e-4, apart = 0.05; /* m */

static const char *const urdfs[] = {"data/demo/arm.urdf", "data/gen3.urdf"};

static void fail(const char *text)
{
    fprintf(stderr, "bench_plan: %s\n", text);
    exit(1);
}

static void sag(mukca_displacement *displacement, const double *q, void *context)
{
    const mukca_corrected *arm = context;
    const double still[MUKCA_MAX_JOINTS] = {0};
    const mukca_joint_state state = {.q = q, .move = still, .placement = -1};
    mukca_effects_displacement(displacement, arm->effects, arm->n_effects, &arm->chain,
                               &arm->geometry, &state);
}

/* Move the true arm from q until its ball is in the socket, up to noise. */
static bool seat(double *q, mukca_corrected *arm, const mukca_place *place, int socket,
                 mukca_random *random)
{
    mukca_frame target = place->pose;
    const mukca_inverse_options options = {.displace = sag, .context = arm};
    for (int a = 0; a < 3; a++)
        target.p[a] +=
            (socket - 0.5) * apart * place->pose.R[3 * a] + noise * mukca_random_normal(random);
    return mukca_inverse_solve(q, &arm->chain, &arm->geometry, &target, false, &options).reached;
}

static void sockets_of(mukca_plan_socket sockets[2], const mukca_place *place, int number)
{
    for (int k = 0; k < 2; k++) {
        memset(&sockets[k], 0, sizeof sockets[k]);
        sockets[k].place = number;
        snprintf(sockets[k].placement, sizeof sockets[k].placement, "%s", place->name);
        snprintf(sockets[k].label, sizeof sockets[k].label, "%d", k);
        for (int a = 0; a < 3; a++)
            sockets[k].centre[a] = place->pose.p[a] + (k - 0.5) * apart * place->pose.R[3 * a];
    }
}

/* Append the rows of a plan, as recorded by the true arm, to those of `base`; sockets by label. */
static void extend(mukca_dataset *out, const mukca_dataset *base, const mukca_plan *plan,
                   const mukca_plan_socket *sockets, mukca_corrected *arm,
                   const mukca_place *places, bool keep, mukca_random *random)
{
    mukca_error error;
    const int n = base->n_joints, old = keep ? base->n_rows : 0;
    if (mukca_dataset_create(out, old + plan->n_rows, n, base->n_sockets, base->n_placements,
                             &error))
        fail(error.text);
    memcpy(out->sockets, base->sockets, (size_t)base->n_sockets * sizeof *out->sockets);
    memcpy(out->placements, base->placements, (size_t)base->n_placements * sizeof *out->placements);
    out->distances = calloc((size_t)base->n_distances, sizeof *out->distances);
    if (!out->distances) fail("out of memory");
    memcpy(out->distances, base->distances, (size_t)base->n_distances * sizeof *out->distances);
    out->n_distances = base->n_distances;
    /* rows grouped by socket, as in a session */
    int row = 0;
    for (int k = 0; k < out->n_sockets; k++) {
        const char *label = out->sockets[k].label;
        const char *name = out->placements[out->sockets[k].placement].name;
        for (int r = 0; r < old; r++)
            if (base->socket[r] == k) {
                memcpy(out->q + row * n, base->q + r * n, (size_t)n * sizeof *out->q);
                out->socket[row++] = k;
            }
        for (int i = 0; i < plan->n_rows; i++) {
            const mukca_plan_socket *s = &sockets[plan->rows[i].socket];
            if (strcmp(s->label, label) != 0 || strcmp(s->placement, name) != 0) continue;
            double q[MUKCA_MAX_JOINTS];
            memcpy(q, plan->rows[i].q, sizeof q);
            if (!seat(q, arm, &places[out->sockets[k].placement], label[0] - '0', random)) continue;
            memcpy(out->q + row * n, q, (size_t)n * sizeof *out->q);
            out->socket[row++] = k;
        }
    }
    out->n_rows = row;
    for (int r = 0; r < row; r++) out->row[r] = r + 1;
}

static double held_out(const mukca_chain *chain, const mukca_dataset *train,
                       const mukca_dataset *test)
{
    static mukca_fit fit;
    mukca_score scores[PLACES + 1], mean;
    mukca_error error;
    if (mukca_fit_run(&fit, chain, train, &(mukca_fit_options){0}, &error)) fail(error.text);
    const mukca_model model = {.chain = chain, .theta = fit.theta};
    if (mukca_evaluate(scores, &mean, &model, test) < 0) fail("out of memory");
    return mean.mae;
}

/* Rows of a plan at a placement, as recorded by the true arm. */
static void follow(mukca_dataset *data, mukca_corrected *arm, mukca_place *place, int rows,
                   const mukca_dataset *like, mukca_random *random)
{
    mukca_plan_socket sockets[2];
    mukca_plan plan;
    mukca_error error;
    /* random postures have any tilt: allow it for planned ones */
    const mukca_plan_options options = {.rows = rows, .noise = noise, .tilt = 4};
    sockets_of(sockets, place, 0);
    if (mukca_plan_run(&plan,
                       &(mukca_plan_task){.chain = &arm->chain,
                                          .theta = NULL,
                                          .data = NULL,
                                          .sockets = sockets,
                                          .n_sockets = 2},
                       &options, &error))
        fail(error.text);
    extend(data, like, &plan, sockets, arm, place, false, random);
    mukca_plan_free(&plan);
}

static void accuracy(int arms)
{
    enum { RANDOM, SAME_PLACE, WAYS };
    double sums[WAYS] = {0};
    int wins[WAYS] = {0};
    printf(
        "# Held-out error on %d other places, mm (rows per socket in brackets; noise %.2g mm per "
        "axis)\n"
        "arm\trobot\trandom[%d]\tplanned[%d]\n",
        PLACES - 1, noise * 1e3, RANDOM_ROWS, PLANNED_ROWS);
    for (int a = 0; a < arms; a++) {
        static mukca_chain chain;
        static mukca_corrected arm;
        const uint64_t seed = 1000 + (uint64_t)a;
        double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS], errors[WAYS];
        mukca_place places[PLACES] = {{.placed = false}};
        mukca_dataset sets[WAYS], test;
        mukca_error error;
        mukca_random random;
        if (mukca_urdf_load(&chain, urdfs[a % 2], NULL, &error)) fail(error.text);
        random = mukca_random_seeded(seed);
        mukca_chain_theta(theta, &chain);
        mukca_simulate_perturb(theta, NULL, &chain, 2e-3, 3e-3, seed);
        mukca_simulate_arm(&arm, &chain, theta);
        for (int p = 0; p < PLACES; p++) snprintf(places[p].name, sizeof places[p].name, "p%d", p);
        mukca_simulate_options recording = {
            .rows = RANDOM_ROWS, .distance = 0.05, .noise = noise, .seed = seed};
        if (mukca_simulate_places(places, PLACES, &chain, apart, seed, &error) ||
            mukca_simulate_sockets(
                &sets[RANDOM],
                &(mukca_simulated_session){
                    .arm = &arm, .places = places, .n_places = 1, .options = &recording},
                &error))
            fail(error.text);
        recording.seed += 500;
        if (mukca_simulate_sockets(&test,
                                   &(mukca_simulated_session){.arm = &arm,
                                                              .places = places + 1,
                                                              .n_places = PLACES - 1,
                                                              .options = &recording},
                                   &error))
            fail(error.text);
        follow(&sets[SAME_PLACE], &arm, &places[0], 2 * PLANNED_ROWS, &sets[RANDOM], &random);
        printf("%d\t%s", a + 1, chain.robot);
        for (int w = 0; w < WAYS; w++) {
            errors[w] = held_out(&chain, &sets[w], &test);
            sums[w] += errors[w] / arms;
            wins[w] += errors[w] <= errors[RANDOM];
            printf("\t%.4f", errors[w] * 1e3);
            mukca_dataset_free(&sets[w]);
        }
        printf("\n");
        mukca_dataset_free(&test);
    }
    printf("mean\t");
    for (int w = 0; w < WAYS; w++) printf("\t%.4f", sums[w] * 1e3);
    printf("\nnot worse than random\t\t");
    for (int w = 1; w < WAYS; w++) printf("\t%d of %d", wins[w], arms);
    printf("\n");
}

/* The true effect of a case: elastic, or another with a similar effect. */
static mukca_effect draw_effect(const mukca_chain *chain, mukca_random *random)
{
    static const struct {
        mukca_effect_kind kind;
        double size;
    } kinds[] = {{MUKCA_EFFECT_JOINT_COMPLIANCE, 2e-5},
                 {MUKCA_EFFECT_LINK_BENDING, 2e-5},
                 {MUKCA_EFFECT_JOINT_SCALE, 5e-4},
                 {MUKCA_EFFECT_ENCODER_ECCENTRICITY, 5e-4},
                 {MUKCA_EFFECT_BACKLASH, 8e-4}};
    const int k = mukca_random_below(random, (int)(sizeof kinds / sizeof *kinds));
    mukca_effect e = {.kind = kinds[k].kind, .placement = -1};
    e.joint = 1 + mukca_random_below(random, chain->n_joints - 3);
    (void)mukca_effect_set_variant(&e, NULL, chain->n_joints);
    const double size = kinds[k].size * exp2(2 * mukca_random_uniform(random) - 1);
    const double phase = 2 * M_PI * mukca_random_uniform(random);
    e.coefficient[0] = e.terms == 2 ? size * cos(phase) : size;
    if (e.terms == 2) e.coefficient[1] = size * sin(phase);
    return e;
}

static bool same(const mukca_effect *a, const mukca_effect *b)
{
    return a->kind == b->kind && a->joint == b->joint;
}

/* Outcomes of tied cases with further rows. */
typedef struct {
    int right, tied, other, promised, promised_right;
} outcome;

enum { PLANNED_TEN, RANDOM_TEN, TIE_WAYS };

/* Replace the rows of the plan by random ones. */
static void shuffle(mukca_plan *plan, const mukca_plan_socket *sockets, int n,
                    const mukca_corrected *arm, const mukca_place *places, int n_places,
                    uint64_t seed)
{
    mukca_dataset any;
    mukca_error error;
    mukca_random random;
    const mukca_simulate_options recording = {
        .rows = plan->n_rows, .distance = 0.05, .seed = seed + 77};
    random = mukca_random_seeded(seed);
    if (mukca_simulate_sockets(
            &any,
            &(mukca_simulated_session){
                .arm = arm, .places = places, .n_places = n_places, .options = &recording},
            &error))
        fail(error.text);
    for (int i = 0; i < plan->n_rows; i++) {
        const int k = mukca_random_below(&random, any.n_sockets);
        for (int j = 0; j < n; j++)
            if (strcmp(sockets[j].label, any.sockets[k].label) == 0 &&
                strcmp(sockets[j].placement, any.placements[any.sockets[k].placement].name) == 0)
                plan->rows[i].socket = j;
        for (int r = 0, of_socket = 0; r < any.n_rows; r++)
            if (any.socket[r] == k && of_socket++ == i)
                memcpy(plan->rows[i].q, any.q + r * any.n_joints,
                       (size_t)any.n_joints * sizeof *any.q);
    }
    mukca_dataset_free(&any);
}

/* Add ten rows for the first tie of `before` and diagnose again; returns the verdict. */
static const char *settle(outcome *sum, int way, const mukca_diagnosis *before,
                          const mukca_dataset *data, mukca_corrected *arm, mukca_place *places,
                          uint64_t seed)
{
    static mukca_diagnosis after;
    const mukca_diagnose_options quick = {.no_folds = true};
    double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    mukca_effect rivals[2];
    mukca_plan_socket sockets[MUKCA_PLAN_MAX_SOCKETS];
    mukca_plan plan;
    mukca_dataset more;
    mukca_error error;
    mukca_random random = mukca_random_seeded(seed + 31);
    mukca_next_poses tie;
    mukca_plan_options options = {.rows = TIE_ROWS};
    mukca_next_poses_pair(&tie, &options, rivals, before, -1);
    mukca_geometry_theta(theta, &arm->chain, &before->geometry);
    const int n =
        mukca_plan_sockets(sockets, MUKCA_PLAN_MAX_SOCKETS, &(int){0}, &before->geometry, data);
    if (mukca_plan_run(&plan,
                       &(mukca_plan_task){.chain = &arm->chain,
                                          .theta = theta,
                                          .data = data,
                                          .sockets = sockets,
                                          .n_sockets = n},
                       &options, &error))
        fail(error.text);
    if (way == RANDOM_TEN) shuffle(&plan, sockets, n, arm, places, data->n_placements, seed);
    extend(&more, data, &plan, sockets, arm, places, true, &random);
    if (mukca_diagnose(&after, &arm->chain, &more, &quick, &error)) fail(error.text);
    const bool right = after.verdict == MUKCA_VERDICT_NAMED && after.n_causes == 1 &&
                       same(&after.causes[0].effect, &arm->effects[0]);
    const bool promised = way != RANDOM_TEN && plan.evidence_after >= MUKCA_PLAN_NAME;
    const char *verdict = right ? "right" : mukca_verdict_name[after.verdict];
    sum->right += right;
    sum->tied += after.verdict == MUKCA_VERDICT_TIED;
    sum->other += after.verdict != MUKCA_VERDICT_TIED && !right;
    sum->promised += promised;
    sum->promised_right += promised && right;
    mukca_plan_free(&plan);
    mukca_dataset_free(&more);
    mukca_diagnosis_free(&after);
    return verdict;
}

static void print_outcome(const char *what, const outcome *o, int n)
{
    printf("%s: %d of %d right (%.0f %%), %d still tied, %d otherwise", what, o->right, n,
           100.0 * o->right / n, o->tied, o->other);
    if (o->promised > 0)
        printf("; %d of the %d where the plan promised it", o->promised_right, o->promised);
    printf("\n");
}

static void ties(int wanted)
{
    static mukca_chain chain;
    static mukca_corrected arm;
    static mukca_diagnosis before;
    outcome sums[TIE_WAYS] = {{0}};
    int found = 0, within = 0, tried = 0;
    printf("case\trobot\ttruth\tjoint\trows\tten_planned\tten_random\n");
    for (uint64_t seed = 1; found < wanted && seed < 100000; seed++) {
        double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
        mukca_place places[5] = {{.placed = false}};
        mukca_dataset data;
        mukca_error error;
        mukca_random random;
        if (mukca_urdf_load(&chain, urdfs[seed % 2], NULL, &error)) fail(error.text);
        random = mukca_random_seeded(seed);
        mukca_chain_theta(theta, &chain);
        mukca_simulate_perturb(theta, NULL, &chain, 2e-3, 3e-3, seed);
        mukca_simulate_arm(&arm, &chain, theta);
        arm.effects[0] = draw_effect(&chain, &random);
        arm.n_effects = 1;
        const int n_places = 2 + mukca_random_below(&random, 3);
        for (int p = 0; p < n_places; p++)
            snprintf(places[p].name, sizeof places[p].name, "p%d", p);
        const mukca_simulate_options recording = {.rows = 12 + mukca_random_below(&random, 19),
                                                  .distance = 0.05,
                                                  .noise = noise,
                                                  .seed = seed};
        if (mukca_simulate_places(places, n_places, &chain, apart, seed, &error) ||
            mukca_simulate_sockets(
                &data,
                &(mukca_simulated_session){
                    .arm = &arm, .places = places, .n_places = n_places, .options = &recording},
                &error))
            continue;
        const mukca_diagnose_options quick = {.no_folds = true};
        if (mukca_diagnose(&before, &chain, &data, &quick, &error)) fail(error.text);
        tried++;
        if (before.verdict == MUKCA_VERDICT_TIED &&
            mukca_next_poses_pair(&(mukca_next_poses){0}, &(mukca_plan_options){0},
                                  (mukca_effect[2]){{0}}, &before, -1)) {
            const char *verdict[TIE_WAYS];
            bool listed = false;
            for (int c = 0; c < before.n_causes; c++) {
                listed |= same(&before.causes[c].effect, &arm.effects[0]);
                for (int t = 0; t < before.causes[c].n_ties; t++)
                    listed |= same(&before.causes[c].ties[t].rival, &arm.effects[0]);
            }
            found++;
            within += listed;
            for (int way = 0; way < TIE_WAYS; way++)
                verdict[way] = settle(&sums[way], way, &before, &data, &arm, places, seed);
            printf("%d\t%s\t%s\t%d\t%d\t%s\t%s\n", found, chain.robot,
                   mukca_effect_table[arm.effects[0].kind]->name, arm.effects[0].joint + 1,
                   data.n_rows, verdict[PLANNED_TEN], verdict[RANDOM_TEN]);
            fflush(stdout);
        }
        mukca_diagnosis_free(&before);
        mukca_dataset_free(&data);
    }
    if (found == 0) return;
    printf("%d sessions, %d of them tied, the truth among the ties in %d\n", tried, found, within);
    print_outcome("10 planned rows more in the same sockets", &sums[PLANNED_TEN], found);
    print_outcome("10 random rows more in the same sockets", &sums[RANDOM_TEN], found);
}

int main(int argc, char **argv)
{
    const int n = argc > 2 ? atoi(argv[2]) : 50;
    if (argc > 1 && strcmp(argv[1], "accuracy") == 0)
        accuracy(n);
    else if (argc > 1 && strcmp(argv[1], "ties") == 0)
        ties(n);
    else
        fail("usage: bench_plan accuracy|ties [N]");
    return 0;
}
