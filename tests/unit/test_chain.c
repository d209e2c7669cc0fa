/* Rotations, forward kinematics, Jacobians and gravity moments against each other and against
 * numerical differentiation. */
#include "arms.h"
#include "close.h"
#include "effect/catalogue.h"
#include "mukca/gravity.h"
#include "mukca/version.h"

static mukca_random seeded = {.state = {1, 2, 3, 4}};

static double uniform(double lo, double hi)
{
    return lo + (hi - lo) * mukca_random_uniform(&seeded);
}

/* Random chain of 7 joints with arbitrary axes, a prismatic one and a fixed element inside. */
static void random_chain(mukca_chain *chain)
{
    make_chain(chain, "RRFRPRRRF", NULL, "j", 0);
    chain->gravity[2] = -9.80665;
    for (int k = 0; k < chain->n_elements; k++) {
        scatter_element(&chain->element[k], 0.2, k % 2 == 0, &seeded);
        if (k % 4 == 2) chain->element[k].axis[2] = -1;
        chain->mass[k] = (mukca_mass){k, uniform(0.5, 4), {0.1, uniform(-0.1, 0.1), -0.05}, {0}};
    }
    chain->n_masses = chain->n_elements;
}

TEST(rotations)
{
    const double angle[] = {0, 1e-12, 1e-5, 0.0099, 0.0101, 0.3, M_PI_2, 3, M_PI - 1e-9, M_PI};
    for (size_t i = 0; i < sizeof angle / sizeof *angle; i++)
        for (int trial = 0; trial < 20; trial++) {
            double axis[3] = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
            const double norm = sqrt(mukca_dot3(axis, axis));
            for (int a = 0; a < 3; a++) axis[a] /= norm;
            double R[9], Q[9], w[3], q[4], e1[3], e2[3], cross[3];
            mukca_rotation_about(R, axis, angle[i]);
            mukca_rotation_log(w, R);
            mukca_rotation_exp(Q, w);
            for (int a = 0; a < 9; a++) assert_close(R[a], Q[a], 1e-14);
            assert_close(sqrt(mukca_dot3(w, w)), angle[i], 1e-14);
            mukca_rotation_to_quaternion(q, R);
            mukca_rotation_from_quaternion(Q, q);
            for (int a = 0; a < 9; a++) assert_close(R[a], Q[a], 1e-14);
            mukca_rotation_transverse(e1, e2, axis);
            mukca_cross(cross, e1, e2);
            for (int a = 0; a < 3; a++) assert_close(cross[a], axis[a], 1e-14);
        }
    const double pitch[] = {0.1, -1.2, M_PI_2, -M_PI_2, M_PI_2 - 1e-7, 2.5};
    for (size_t i = 0; i < sizeof pitch / sizeof *pitch; i++) {
        const double rpy[3] = {0.4, pitch[i], -2.2};
        double R[9], Q[9], back[3];
        mukca_rotation_from_rpy(R, rpy);
        mukca_rotation_to_rpy(back, R, rpy);
        mukca_rotation_from_rpy(Q, back);
        for (int a = 0; a < 9; a++) assert_close(R[a], Q[a], 1e-9);
        for (int a = 0; a < 3; a++) assert_close(back[a], rpy[a], 1e-6);
    }
}

TEST(kinematics)
{
    mukca_chain chain;
    mukca_geometry geometry;
    random_chain(&chain);
    double theta[6 * MUKCA_MAX_ELEMENTS], q[37][7];
    mukca_chain_theta(theta, &chain);
    mukca_geometry_set(&geometry, &chain, NULL);
    for (int r = 0; r < 37; r++)
        for (int j = 0; j < 7; j++) q[r][j] = uniform(-4, 4);
    q[36][4] = 3e6;
    for (int r = 0; r < 37; r++) {
        mukca_displacement d = {.any_rotation = true};
        mukca_frame tip;
        double p[3], J[6 * 7], P[3 * 6 * MUKCA_MAX_ELEMENTS], again[3];
        mukca_fk_position(p, &geometry, q[r], NULL);
        mukca_fk_pose(&tip, &geometry, q[r], NULL);
        for (int i = 0; i < 3; i++) assert_close(p[i], tip.p[i], 5e-14);

        for (int j = 0; j < 7; j++) {
            d.q[j] = uniform(-1e-2, 1e-2);
            for (int i = 0; i < 3; i++) d.rotation[j][i] = uniform(-1e-2, 1e-2);
        }
        for (int i = 0; i < 3; i++) d.base[i] = uniform(-0.1, 0.1), d.tip[i] = uniform(-0.1, 0.1);
        mukca_fk_position(p, &geometry, q[r], &d);
        mukca_fk_jacobian(J, &tip, &geometry, q[r], &d);
        for (int i = 0; i < 3; i++) assert_close(p[i], tip.p[i], 5e-14);
        if (r < 36)
            for (int j = 0; j < 7; j++) {
                double a[7], up[3], down[3];
                memcpy(a, q[r], sizeof a);
                a[j] += 1e-5;
                mukca_fk_position(up, &geometry, a, &d);
                a[j] -= 2e-5;
                mukca_fk_position(down, &geometry, a, &d);
                for (int i = 0; i < 3; i++)
                    assert_close(J[i * 7 + j], (up[i] - down[i]) / 2e-5, 1e-9);
            }
        mukca_fk_parameter_jacobian(P, again, &geometry, theta, q[r]);
        mukca_fk_position(p, &geometry, q[r], NULL);
        for (int i = 0; i < 3; i++) assert_close(p[i], again[i], 1e-13);
        for (int t = 0; t < 6 * chain.n_elements; t++) {
            double moved[6 * MUKCA_MAX_ELEMENTS], up[3], down[3];
            mukca_geometry g;
            memcpy(moved, theta, sizeof moved);
            moved[t] += 1e-6;
            mukca_geometry_set(&g, &chain, moved);
            mukca_fk_position(up, &g, q[r], NULL);
            moved[t] -= 2e-6;
            mukca_geometry_set(&g, &chain, moved);
            mukca_fk_position(down, &g, q[r], NULL);
            for (int i = 0; i < 3; i++)
                assert_close(P[i * 6 * chain.n_elements + t], (up[i] - down[i]) / 2e-6, 1e-8);
        }
    }
    /* many at once: the same bits in every lane and in the last block; one angle is beyond the
     * lanes */
    for (int rows = 1; rows <= 37; rows += 4) {
        double many[37][3], one[3];
        mukca_fk_positions(many[0], &geometry, q[37 - rows], rows);
        for (int r = 0; r < rows; r++) {
            mukca_fk_position(one, &geometry, q[37 - rows + r], NULL);
            assert_memory_equal(many[r], one, sizeof one);
        }
    }
    double nan_q[7] = {0, 0, NAN, 0, 0, 0, 0}, p[3];
    mukca_fk_position(p, &geometry, nan_q, NULL);
    assert_true(isnan(p[0]));
}

/* Potential energy of the masses, from the frames alone. */
static double energy(const mukca_chain *chain, const mukca_geometry *geometry, const double *q,
                     const mukca_displacement *d)
{
    double sum = 0;
    for (int m = 0; m < chain->n_masses; m++) {
        mukca_geometry part = *geometry;
        mukca_frame frame;
        double x[3];
        part.n_elements = chain->mass[m].element + 1;
        mukca_fk_pose(&frame, &part, q, d);
        mukca_mat3_vec(x, frame.R, chain->mass[m].com);
        for (int i = 0; i < 3; i++)
            sum -= chain->mass[m].kg * chain->gravity[i] * (x[i] + frame.p[i]);
    }
    return sum;
}

TEST(moments)
{
    mukca_chain chain;
    mukca_geometry geometry;
    random_chain(&chain);
    mukca_geometry_set(&geometry, &chain, NULL);
    for (int trial = 0; trial < 10; trial++) {
        double q[7];
        mukca_gravity_load load;
        const double h = 1e-5;
        for (int j = 0; j < 7; j++) q[j] = uniform(-3, 3);
        mukca_chain_moments(&load, &chain, &geometry, q, NULL, 0);
        for (int j = 0; j < 7; j++) {
            mukca_displacement d = {.any_rotation = true};
            d.q[j] = h;
            double up = energy(&chain, &geometry, q, &d);
            d.q[j] = -h;
            assert_close(load.torque[j], (up - energy(&chain, &geometry, q, &d)) / (2 * h), 1e-6);
            for (int i = 0; i < 3; i++) {
                memset(&d, 0, sizeof d);
                d.any_rotation = true;
                d.rotation[j][i] = h;
                up = energy(&chain, &geometry, q, &d);
                d.rotation[j][i] = -h;
                assert_close(load.moment[j][i], (up - energy(&chain, &geometry, q, &d)) / (2 * h),
                             1e-6);
            }
        }
        for (int i = 0; i < 3; i++) {
            mukca_displacement d = {.any_rotation = true};
            d.base[i] = h;
            const double up = energy(&chain, &geometry, q, &d);
            d.base[i] = -h;
            assert_close(load.base[i], (up - energy(&chain, &geometry, q, &d)) / (2 * h), 1e-6);
        }
    }
}

TEST(wrong_terms)
{
    const char *const wrong[] = {"motion=cone+1 u", "motion=fixed3 sin u", "motion=fixed1 sin w",
                                 "motion=12 sin u", "fixed1 sin u",        "-"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        mukca_effect e = {.kind = MUKCA_EFFECT_AXIS_WOBBLE};
        assert_int_equal(mukca_effect_term_parse(&e, wrong[i], 1), -1);
    }
}

/* Each effect says all of itself, its candidates are distinct, and their texts read back. */
TEST(catalogue)
{
    mukca_effect_survey survey = {.n_joints = 3,
                                  .n_placements = 2,
                                  .moments = true,
                                  .torques = true,
                                  .moved = true,
                                  .dwelled = true,
                                  .by_command = true,
                                  .commanded = true,
                                  .sockets = true,
                                  .pairs = true};
    for (int j = 0; j < 3; j++) {
        survey.joint[j].turns = true;
        survey.joint[j].range = 1;
        survey.joint[j].torque_low = -1;
        survey.joint[j].torque_high = survey.joint[j].torque_most = 2;
    }
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
        const mukca_effect_info *info = mukca_effect_table[kind];
        const int joint = mukca_effect_has_joint(kind) ? 1 : -1;
        mukca_effect e, other;
        assert_true(info->name && info->title && info->unit && info->sentence && info->terms > 0 &&
                    info->terms <= MUKCA_MAX_TERMS);
        assert_int_equal(mukca_effect_find(info->name), kind);
        for (int i = 0; mukca_effect_candidate(&e, (mukca_effect_kind)kind, joint, &survey, i);
             i++) {
            char text[MUKCA_EFFECT_TEXT];
            for (int k = 0; k < i; k++) {
                mukca_effect_candidate(&other, (mukca_effect_kind)kind, joint, &survey, k);
                assert_false(mukca_effect_same(&e, &other));
            }
            other = (mukca_effect){.kind = e.kind, .joint = joint, .placement = e.placement};
            mukca_effect_variant_text(text, &e);
            assert_null(mukca_effect_set_variant(&other, *text ? text : NULL, 3));
            assert_true(mukca_effect_same(&e, &other));
            for (int t = 0; t < e.terms && !mukca_effect_has(kind, MUKCA_TRAIT_RECORDING_FAULT);
                 t++) {
                other = (mukca_effect){.kind = e.kind, .joint = joint};
                mukca_effect_term_text(text, &e, t);
                assert_int_equal(mukca_effect_term_parse(&other, text, 3), t);
                assert_true(mukca_effect_same(&other, &e));
                assert_int_equal(other.terms, e.terms);
                strcat(text, "?");
                assert_int_equal(mukca_effect_term_parse(&other, text, 3), -1);
            }
        }
    }
    mukca_effect e = {.kind = MUKCA_EFFECT_BACKLASH}; /* variants without unit or sign */
    assert_null(mukca_effect_set_variant(&e, "0.1", 3));
    e = (mukca_effect){.kind = MUKCA_EFFECT_JOINT_COUPLING, .joint = 1};
    assert_null(mukca_effect_set_variant(&e, "1", 3));
    assert_int_equal(mukca_effect_find("no_such_effect"), -1);
}

TEST(version)
{
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", MUKCA_VERSION_MAJOR, MUKCA_VERSION_MINOR,
             MUKCA_VERSION_PATCH);
    assert_string_equal(text, MUKCA_VERSION);
    assert_string_equal(text, mukca_version());
}

TEST_MAIN(NULL, NULL)
