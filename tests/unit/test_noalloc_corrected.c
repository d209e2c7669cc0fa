/* The controllers' interface: equal to the program's own kinematics, right Jacobians, bad tables
 * refused, and a million calls without allocation (the linker wraps the allocator). */
#include "close.h"
#include "gen3.h"
#include "io/offsets.h"
#include "math/random.h"
#include "mukca/corrected.h"
#include "mukca/gravity.h"
#include "noalloc.h"

static mukca_chain chain;
static mukca_offsets offsets;
static mukca_corrected model, arm, other;
static mukca_geometry geometry;
static char text[1 << 17];

static void add_effect(mukca_effect_kind kind, int joint, const char *variant, double a, double b)
{
    mukca_effect *e = &offsets.effects[offsets.n_effects++];
    *e = (mukca_effect){.kind = kind, .joint = joint, .placement = -1, .coefficient = {a, b}};
    assert_null(mukca_effect_set_variant(e, variant, chain.n_joints));
}

/* A table of the Gen3 with offsets, masses and effects, as the program writes it. */
FIXTURE(setup)
{
    mukca_random random = mukca_random_seeded(11);
    gen3_chain(&chain);
    snprintf(chain.robot, sizeof chain.robot, "gen3");
    snprintf(chain.tip, sizeof chain.tip, "tip");
    for (int k = 0; k < 7; k++)
        chain.mass[chain.n_masses++] = (mukca_mass){k, 1.0 + 0.1 * k, {0.01, -0.02, -0.06}, {0}};
    mukca_offsets_init(&offsets, &chain);
    for (int i = 0; i < 6 * chain.n_elements; i++) {
        offsets.theta[i] += 1e-3 * mukca_random_normal(&random);
        offsets.listed[i] = offsets.identifiable[i] = 1;
    }
    add_effect(MUKCA_EFFECT_JOINT_COMPLIANCE, 1, NULL, 5e-5, 0);
    add_effect(MUKCA_EFFECT_LINK_BENDING, 3, NULL, 4e-5, 0);
    add_effect(MUKCA_EFFECT_BASE_COMPLIANCE, -1, NULL, 6e-5, 0);
    add_effect(MUKCA_EFFECT_BACKLASH, 5, "1000mNm", 1e-3, 0);
    add_effect(MUKCA_EFFECT_GEAR_HARMONIC, 3, "240", 1e-4, -2e-4);
    add_effect(MUKCA_EFFECT_JOINT_COUPLING, 2, "-1", 3e-4, 0);
    mukca_geometry_set(&geometry, &chain, offsets.theta);
    FILE *file = tmpfile();
    if (!file || mukca_offsets_write(file, &offsets, &chain, NULL, "a comment", &error)) return 1;
    rewind(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    return mukca_corrected_parse(&model, text, strlen(text), &error) != MUKCA_OK;
}

static void random_angles(double *q, mukca_random *random)
{
    for (int j = 0; j < 7; j++) q[j] = 4 * mukca_random_uniform(random) - 2;
}

TEST(equals_the_program)
{
    mukca_random random = mukca_random_seeded(12);
    assert_int_equal(model.chain.n_joints, 7);
    assert_int_equal(model.n_effects, 6);
    assert_string_equal(model.chain.robot, "gen3");
    for (int i = 0; i < 200; i++) {
        double q[7], p[3];
        mukca_displacement d;
        mukca_frame T, expected;
        random_angles(q, &random);
        mukca_effects_displacement(&d, offsets.effects, offsets.n_effects, &chain, &geometry,
                                   &(mukca_joint_state){.q = q, .placement = -1});
        mukca_fk_pose(&expected, &geometry, q, &d);
        mukca_corrected_pose(&T, &model, q, NULL);
        mukca_corrected_position(p, &model, q, NULL);
        assert_frame(&T, &expected, 1e-12);
        for (int a = 0; a < 3; a++) assert_close(p[a], T.p[a], 1e-13);
    }
}

/* Every kind of effect at several joints, in every variant that changes the derivative. */
static void add_every_effect(void)
{
    static const char *const wobbles[] = {"fixed2", "turning1", "cone-2"};
    mukca_random random = mukca_random_seeded(14);
    arm.n_effects = 0;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++)
        for (int i = 0; i < (mukca_effect_has_joint(kind) ? 3 : 1); i++) {
            mukca_effect *e = &arm.effects[arm.n_effects++];
            const char *variant = kind == MUKCA_EFFECT_GEAR_HARMONIC  ? "5"
                                  : kind == MUKCA_EFFECT_AXIS_WOBBLE  ? wobbles[i]
                                  : kind == MUKCA_EFFECT_READBACK_LAG ? "command"
                                                                      : NULL;
            *e = (mukca_effect){.kind = (mukca_effect_kind)kind,
                                .joint = mukca_effect_has_joint(kind) ? (kind + 3 * i) % 7 : -1,
                                .placement = 0};
            assert_null(mukca_effect_set_variant(e, variant, 7));
            e->terms = mukca_effect_terms(e);
            /* N m deflect less than angles do; soft enough to count */
            const bool loaded = (mukca_effect_table[kind]->needs & MUKCA_NEEDS_MASSES) &&
                                kind != MUKCA_EFFECT_BACKLASH;
            for (int t = 0; t < e->terms; t++)
                e->coefficient[t] = (loaded ? 6e-5 : 3e-3) * (1 + mukca_random_uniform(&random));
        }
}

/* The arm with every effect; with sliding joints, with a base that stands askew. */
static void set_arm(bool slides, bool askew, mukca_random *random)
{
    arm = model;
    for (int j = 0; j < 7 && slides; j++)
        if (j % 3 == 1) arm.chain.element[arm.chain.joint_element[j]].type = MUKCA_PRISMATIC;
    for (int a = 0; a < 3 && askew; a++) arm.chain.gravity[a] = 6 * mukca_random_normal(random);
    mukca_geometry_set(&arm.geometry, &arm.chain, offsets.theta);
    add_every_effect();
}

/* Add the displacement by one effect under the load of `now`. */
static void displace_by(mukca_displacement *d, const mukca_effect *e, const mukca_chain *of,
                        const mukca_joint_state *now)
{
    double basis[MUKCA_MAX_TERMS][3], along[MUKCA_MAX_JOINTS];
    const mukca_effect_site site = mukca_effect_table[e->kind]->site;
    const double *axis = e->joint < 0 ? NULL : of->element[of->joint_element[e->joint]].axis;
    mukca_effect_direction(along, of->n_joints, e, now);
    for (int j = 0; j < of->n_joints; j++) d->q[j] += e->coefficient[0] * along[j];
    mukca_effect_basis(basis, e, axis, now);
    double *into = site == MUKCA_SITE_ANGLE      ? &d->q[e->joint]
                   : site == MUKCA_SITE_ROTATION ? d->rotation[e->joint]
                   : site == MUKCA_SITE_BASE     ? d->base
                                                 : d->tip;
    for (int i = 0; i < 3 * e->terms && site != MUKCA_SITE_ANGLES; i++)
        if (site != MUKCA_SITE_ANGLE || i % 3 == 0)
            into[i % 3] += e->coefficient[i / 3] * basis[i / 3][i % 3];
    d->any_rotation |= site == MUKCA_SITE_ROTATION || site == MUKCA_SITE_BASE;
}

/* Load of the arm in its displaced posture. */
static void find_load(mukca_gravity_load *load, const double *q, const mukca_displacement *d,
                      double payload_kg)
{
    mukca_geometry bent = arm.geometry;
    mukca_frame tilt = {{0}, {0}};
    double turned[MUKCA_MAX_JOINTS], E[9];
    for (int j = 0; j < arm.chain.n_joints; j++) {
        double *R = bent.origin[arm.chain.joint_element[j]].R, before[9];
        memcpy(before, R, sizeof before);
        mukca_rotation_exp(E, d->rotation[j]);
        mukca_mat3_mul(R, before, E);
        turned[j] = q[j] + d->q[j];
    }
    mukca_rotation_exp(tilt.R, d->base);
    mukca_frame_multiply(&bent.origin[0], &tilt, &bent.origin[0]);
    mukca_chain_moments(load, &arm.chain, &bent, turned, NULL, payload_kg);
}

/* Against a hundred rounds, each with the load at the posture of the one before, by the plain model
 * of displaced frames.  Soft arms, turning and sliding joints, a payload, a base that stands askew.
 */
TEST(rest_is_the_fixed_point)
{
    mukca_random random = mukca_random_seeded(16);
    for (int i = 0; i < 200; i++) {
        double q[7];
        mukca_displacement d = {0}, found;
        mukca_gravity_load load;
        mukca_frame T, expected;
        /* ten springs and plays at once: as soft as real arms, and ten times as soft */
        const double within = i % 3 ? 1e-7 : 3e-5;
        set_arm(i % 2, i % 3, &random);
        for (int e = 0; e < arm.n_effects; e++)
            arm.effects[e].coefficient[0] *= i % 3 ? 0.1 * (i % 3) : 1;
        random_angles(q, &random);
        mukca_joint_state now = {.q = q, .time = 100, .payload_kg = i % 4};
        for (int round = 0; round < 100; round++) {
            find_load(&load, q, &d, now.payload_kg);
            now.torque = load.torque;
            now.moment = (const double(*)[3])load.moment;
            now.base_moment = load.base;
            d = (mukca_displacement){.any_rotation = false};
            for (int e = 0; e < arm.n_effects; e++)
                displace_by(&d, &arm.effects[e], &arm.chain, &now);
        }
        mukca_effects_displacement(&found, arm.effects, arm.n_effects, &arm.chain, &arm.geometry,
                                   &now);
        for (int j = 0; j < 7; j++) {
            assert_close(found.q[j], d.q[j], within);
            for (int a = 0; a < 3; a++)
                assert_close(found.rotation[j][a], d.rotation[j][a], within);
        }
        for (int a = 0; a < 3; a++) assert_close(found.base[a], d.base[a], within);
        mukca_fk_pose(&expected, &arm.geometry, q, &d);
        mukca_corrected_pose(&T, &arm, q, &now);
        assert_frame(&T, &expected, within);
    }
}

/* The Jacobian against differences of fourth order, of turning and sliding joints, of an upright
 * base and one that stands askew: all of it without effects of the load, else but for the change of
 * their displacement, here less than 0.03 m per rad. */
TEST(jacobian_lacks_the_change_of_the_deflection_alone)
{
    const double h = 2e-4, weight[4] = {1, -8, 8, -1}, at[4] = {-2, -1, 1, 2};
    mukca_random random = mukca_random_seeded(15);
    for (int i = 0; i < 60; i++) {
        double q[7], J[42], command[7], move[7];
        set_arm(i % 2, i % 5 > 1, &random);
        for (int e = 0; e < arm.n_effects; e++)
            if (mukca_effect_table[arm.effects[e].kind]->needs & MUKCA_NEEDS_MASSES)
                arm.effects[e].coefficient[0] *= i % 3 ? 0.1 : 0;
        random_angles(q, &random);
        for (int j = 0; j < 7; j++) {
            command[j] = q[j] + 0.01;
            move[j] = 0.1 * mukca_random_normal(&random);
        }
        const mukca_joint_state now = {
            .command = command, .move = move, .time = 100, .payload_kg = 2};
        mukca_frame tip, same;
        mukca_corrected_jacobian(J, &tip, &arm, q, &now);
        mukca_corrected_pose(&same, &arm, q, &now);
        assert_frame(&tip, &same, 1e-13);
        for (int j = 0; j < 7; j++) {
            double rate[6] = {0};
            for (int k = 0; k < 4; k++) {
                double moved[7], w[3];
                mukca_frame side;
                memcpy(moved, q, sizeof moved);
                moved[j] += at[k] * h;
                mukca_corrected_pose(&side, &arm, moved, &now);
                mukca_rotation_difference(w, side.R, tip.R);
                for (int a = 0; a < 3; a++) {
                    rate[a] += weight[k] * (side.p[a] - tip.p[a]) / (12 * h);
                    rate[3 + a] += weight[k] * w[a] / (12 * h);
                }
            }
            for (int a = 0; a < 6; a++) assert_close(J[a * 7 + j], rate[a], i % 3 ? 3e-2 : 1e-6);
        }
    }
}

/* Each for what is wrong with it, and not only as it was edited. */
TEST(bad_tables_are_refused)
{
    static char broken[1 << 17];
    static const char *const spoil[][2] = {
        {"# element:", "# alement:"},       {"revolute", "revolving"},
        {"\tx\tm\t", "\tq\tm\t"},           {"joint_3\ty", "joint_9\ty"},
        {"order=240", "order=900"},         {"neighbour=-1", "neighbour=-7"},
        {"joint\tparameter", "joint\tpar"}, {"# mass:\t0", "# mass:\t99"},
        {"# gravity:\t0", "# gravity:\tx"}};
    assert_ok(mukca_corrected_parse(&other, text, strlen(text), &error));
    for (size_t i = 0; i < sizeof spoil / sizeof *spoil; i++) {
        const char *at = strstr(text, spoil[i][0]);
        assert_non_null(at);
        const size_t before = (size_t)(at - text);
        snprintf(broken, sizeof broken, "%.*s%s%s", (int)before, text, spoil[i][1],
                 at + strlen(spoil[i][0]));
        if (i == 0) /* all of them */
            while ((at = strstr(broken, "# element:"))) broken[at - broken + 2] = 'a';
        assert_refused(mukca_corrected_parse_named(&other, broken, strlen(broken), "table",
                                                   MUKCA_ACCEPT_EDITED, &error),
                       "table:");
    }
    assert_int_equal(mukca_corrected_parse(&other, "", 0, &error), MUKCA_INPUT);
    assert_int_equal(mukca_corrected_load(&other, "/nonexistent/table", &error), MUKCA_INPUT);
    assert_refused(mukca_corrected_load(&other, "README.md", &error),
                   "README.md:"); /* the file, not only its line */
}

TEST(a_million_calls_allocate_nothing)
{
    double q[7], p[3], J[42], sum = 0;
    mukca_frame T;
    static mukca_corrected bare;
    mukca_random random = mukca_random_seeded(14);
    bare = model;
    bare.n_effects = 0;
    calls = 0;
    for (int i = 0; i < 1000000; i++) {
        const mukca_corrected *m = i % 8 ? &bare : &model;
        random_angles(q, &random);
        if (i % 3 == 0) mukca_corrected_position(p, m, q, NULL);
        if (i % 3 == 1) mukca_corrected_pose(&T, m, q, NULL);
        if (i % 3 == 2) mukca_corrected_jacobian(J, &T, i % 64 ? &bare : &model, q, NULL);
        sum += p[0];
    }
    assert_int_equal(calls, 0);
    assert_true(isfinite(sum));
    void *volatile memory = malloc(1); /* the count counts */
    free(memory);
    assert_int_equal(calls, 2);
}

TEST_MAIN(setup, NULL)
