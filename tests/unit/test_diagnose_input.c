/* Recordings that cannot be diagnosed, or not in full: each ends in a verdict and a reason. */
#include "diagnosed.h"
#include "model/dataset_subset.h"

static const char soft[] = "joint_compliance:joint_2=3e-5"; /* a flexible shoulder */

/* An arm with those effects, 0.1 mm of noise. */
static void record_rows(const char *effects, int rows, bool effort)
{
    simulate(effects, 4);
    s.how.rows = rows;
    s.how.effort = effort;
    record_again();
}

static bool ordered(double low, double middle, double high)
{
    return low <= middle && middle <= high;
}

/* Diagnose, and check what must hold whatever the rows are. */
static void check_diagnosis(void)
{
    diagnose((mukca_diagnose_options){.applied = true});
    assert_true((d->verdict == MUKCA_VERDICT_UNTESTABLE) == (d->why != NULL));
    for (int i = 0; i < d->n_causes; i++) {
        const mukca_cause *c = &d->causes[i];
        assert_true(ordered(c->low, c->amplitude, c->high));
        assert_true(ordered(0, c->probability, 1));
        for (int k = 0; k < i; k++) {
            const mukca_cause *other = &d->causes[k];
            assert_false(c->effect.kind == other->effect.kind &&
                         c->effect.joint == other->effect.joint &&
                         mukca_effect_same(&c->effect, &other->effect) &&
                         c->effect.placement == other->effect.placement && c->row == other->row &&
                         c->socket == other->socket);
        }
    }
    for (int i = 0; i < d->n_tested; i++)
        assert_true(d->tested[i].testable ? d->tested[i].limit > 0 : d->tested[i].why != NULL);
    for (int i = 0; i < d->n_faults; i++) assert_true(ordered(0, d->faults[i].size_m, 10));
    if (d->applied.fitted) {
        double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
        mukca_geometry_theta(theta, &s.chain, &d->applied.geometry);
        for (int i = 0; i < MUKCA_PARAMETERS * s.chain.n_elements; i++)
            assert_true(isfinite(theta[i]));
    }
}

/* Why an effect cannot be tested (at a joint, -1: at all); NULL where it can. */
static const char *why(int kind, int joint)
{
    for (int i = 0; i < d->n_tested; i++)
        if ((int)d->tested[i].effect == kind && d->tested[i].joint == joint)
            return d->tested[i].why;
    return NULL;
}

TEST(without_masses_elastic_effects_are_untestable)
{
    record_rows(soft, 25, false);
    s.chain.n_masses = 0;
    check_diagnosis();
    static const int kinds[] = {MUKCA_EFFECT_JOINT_COMPLIANCE, MUKCA_EFFECT_LINK_BENDING,
                                MUKCA_EFFECT_BASE_COMPLIANCE, MUKCA_EFFECT_BACKLASH};
    for (int i = 0; i < 4; i++) {
        assert_part(why(kinds[i], -1), "--inertials");
        for (int c = 0; c < d->n_causes; c++)
            assert_int_not_equal(d->causes[c].effect.kind, kinds[i]);
    }
}

TEST(efforts_stand_in_for_masses)
{
    record_rows(soft, 25, true);
    s.chain.n_masses = 0;
    check_diagnosis();
    assert_int_equal(d->causes[0].effect.kind, MUKCA_EFFECT_JOINT_COMPLIANCE);
    assert_int_equal(d->causes[0].effect.joint, 1);
    assert_true(isnan(d->efforts_correlation));
    assert_false(d->turned_efforts);
    const double size = d->causes[0].amplitude, held_out = d->explained_m;
    /* a spring yields to its load: efforts of the opposite sign are recognised */
    for (int i = 0; i < data.n_rows * data.n_joints; i++) data.effort[i] = -data.effort[i];
    check_diagnosis();
    assert_true(d->turned_efforts);
    assert_int_equal(d->causes[0].effect.kind, MUKCA_EFFECT_JOINT_COMPLIANCE);
    assert_int_equal(d->causes[0].effect.joint, 1);
    assert_close(d->causes[0].amplitude, size, 1e-12);
    assert_close(d->explained_m, held_out, 1e-12);
}

/* Another cause that a spring of negative torque would imitate. */
TEST(efforts_without_a_spring_keep_their_sign)
{
    static const char *const effects[] = {NULL, "joint_scale:joint_2=1e-3",
                                          "joint_scale:joint_2=-1e-3"};
    for (int i = 0; i < 3; i++) {
        record_rows(effects[i], 25, true);
        s.chain.n_masses = 0;
        check_diagnosis();
        assert_false(d->turned_efforts);
    }
}

TEST(efforts_of_the_wrong_sign_are_noticed)
{
    record_rows(soft, 25, true);
    check_diagnosis();
    assert_true(d->efforts_correlation > 0.999);
    for (int i = 0; i < data.n_rows * data.n_joints; i++) data.effort[i] = -data.effort[i];
    check_diagnosis();
    assert_true(d->efforts_correlation < -0.999);
    assert_int_equal(d->causes[0].effect.kind, MUKCA_EFFECT_JOINT_COMPLIANCE);
    const double size = d->causes[0].amplitude; /* as if there were none */
    free(data.effort);
    data.effort = NULL;
    check_diagnosis();
    assert_close(d->causes[0].amplitude, size, 1e-12);
}

TEST(one_placement)
{
    simulate(NULL, 4);
    mukca_dataset_free(&data);
    record_at(&data, &s, 1);
    check_diagnosis();
    assert_int_equal(d->verdict, MUKCA_VERDICT_NONE);
    assert_part(why(MUKCA_EFFECT_ZERO_JUMP, -1), "record a second one");
    assert_part(why(MUKCA_EFFECT_BALL_SHIFT, -1), "record a second one");
    assert_int_equal(d->folds, 2); /* its sockets */
}

TEST(a_socket_with_three_rows)
{
    mukca_dataset few;
    record_rows(soft, 25, false);
    unsigned char keep[256];
    for (int i = 0, n = 0; i < data.n_rows; i++) keep[i] = data.socket[i] != 3 || n++ < 3;
    assert_ok(mukca_dataset_subset(&few, &data, keep, &error));
    assert_int_equal(few.n_rows, data.n_rows - 22);
    mukca_dataset_free(&data);
    data = few;
    check_diagnosis();
    assert_int_equal(d->causes[0].effect.kind, MUKCA_EFFECT_JOINT_COMPLIANCE);
    assert_int_equal(d->causes[0].effect.joint, 1);
}

TEST(too_few_rows)
{
    for (int rows = 2; rows < 12; rows++) {
        record_rows(soft, rows, false);
        check_diagnosis();
        if (rows < 3) assert_int_equal(d->n_causes, 0);
        for (int i = 0; i < d->n_causes; i++) /* what is sure is true */
            assert_true(d->causes[i].effect.kind == MUKCA_EFFECT_JOINT_COMPLIANCE ||
                        d->causes[i].probability < 0.95 || d->causes[i].n_ties > 0);
    }
}

/* An arm whose elbow is locked is another arm; nothing about the elbow can be told. */
TEST(a_constant_joint)
{
    set_scene(&s, NULL, 4);
    s.how.noise = 1e-4;
    mukca_element *elbow = &s.chain.element[s.chain.joint_element[3]];
    elbow->lower = -1.2 - 1e-9; /* the simulation keeps within limits */
    elbow->upper = -1.2 + 1e-9;
    s.arm.chain.element[s.chain.joint_element[3]] = *elbow;
    memset(s.places, 0, sizeof s.places);
    static const char *const names[PLACES] = {"a", "b", "c", "d"};
    for (int p = 0; p < PLACES; p++) snprintf(s.places[p].name, 64, "%s", names[p]);
    assert_ok(mukca_simulate_places(s.places, PLACES, &s.chain, 0.05, 4, &error));
    record_again();
    check_diagnosis();
    assert_int_equal(d->n_causes, 0);
    static const int kinds[] = {MUKCA_EFFECT_JOINT_SCALE, MUKCA_EFFECT_ENCODER_ECCENTRICITY,
                                MUKCA_EFFECT_GEAR_HARMONIC, MUKCA_EFFECT_AXIS_WOBBLE,
                                MUKCA_EFFECT_APPROACH_HYSTERESIS};
    for (int i = 0; i < 5; i++) assert_part(why(kinds[i], 3), "did not move");
}

TEST(all_labels_wrong)
{
    record_rows(soft, 25, false);
    for (int i = 0; i < data.n_rows; i++)
        data.socket[i] ^= 1; /* both swapped: a pair all the same */
    check_diagnosis();
    assert_int_equal(d->n_faults, 0);
    for (int i = 0; i < data.n_rows; i++) data.socket[i] ^= i % 3 == 0; /* a third of them */
    check_diagnosis();
    assert_int_equal(d->n_faults, MUKCA_MAX_FAULTS);
    for (int i = 0; i < d->n_faults; i++)
        assert_int_equal(d->faults[i].kind, MUKCA_FAULT_WRONG_SOCKET);
}

/* --distance ten times too large: named, with its size, though no prior expects it. */
TEST(a_wild_distance)
{
    simulate(NULL, 4);
    for (int i = 0; i < data.n_distances; i++) data.distances[i].distance = 0.5;
    check_diagnosis();
    assert_int_equal(d->n_causes, 1);
    assert_int_equal(d->causes[0].effect.kind, MUKCA_EFFECT_SOCKET_DISTANCE);
    assert_close(d->causes[0].amplitude, -0.45, 1e-3);
}

TEST_MAIN(set_up, tear_down)
