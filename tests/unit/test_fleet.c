/* Pooled summaries give the population, orders of ripple and departing arms, with intervals that
 * hold the truth; what does not belong together is refused. */
#include "close.h"
#include "fleet/fleet.h"
#include "io/summary.h"
#include "math/random.h"
#include "scratch.h"

enum { JOINTS = 6, TERMS = 2 * JOINTS, ARMS = 12, SOFT = 2 };

#define TRUE_MEAN 40e-6
#define TRUE_SPREAD 8e-6

/* An arm with compliance c at joint SOFT, known to `sigma`, the other coefficients as well. */
static void make_summary(mukca_summary *s, int arm, double c, double sigma, mukca_random *random)
{
    memset(s, 0, sizeof *s);
    s->model.n_joints = JOINTS;
    snprintf(s->model.robot, MUKCA_NAME_SIZE, "six");
    for (int j = 0; j < JOINTS; j++) snprintf(s->model.joint[j], MUKCA_NAME_SIZE, "j%d", j + 1);
    snprintf(s->arm, sizeof s->arm, "arm%02d", arm);
    s->path = "arm.json";
    s->data = 1000u + (unsigned)arm;
    s->samples = 100;
    s->sigma_m = 1e-4;
    for (int i = 0; i < TERMS; i++) {
        const double precision = 1 / (sigma * sigma);
        s->information[mukca_fleet_packed(i) + i] = precision;
        s->vector[i] = precision * ((i == SOFT ? c : 0) + sigma * mukca_random_normal(random));
    }
}

static void take(mukca_fleet *f, const mukca_summary *s)
{
    assert_ok(mukca_fleet_take(f, s, &error));
}

/* A fleet in which each arm alone sees the shared compliance at two standard errors. */
static void make_fleet(mukca_fleet *f, double mean, double broken, uint64_t seed)
{
    static mukca_summary s[ARMS];
    mukca_random random = mukca_random_seeded(seed);
    memset(f, 0, sizeof *f);
    for (int a = 0; a < ARMS; a++) {
        const double own = mean > 0 ? mean + TRUE_SPREAD * mukca_random_normal(&random) : 0;
        make_summary(&s[a], a, a == 7 ? own + broken : own, 20e-6, &random);
        take(f, &s[a]);
    }
    assert_ok(mukca_fleet_gather(f, NULL));
}

TEST(test_shared_is_found)
{
    int inside = 0;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        mukca_fleet f;
        make_fleet(&f, TRUE_MEAN, 0, seed);
        assert_ok(mukca_fleet_pool(&f, &error));
        assert_int_equal(f.population.n, TERMS);
        assert_true(f.traits.list[SOFT].probability > 0.95);
        assert_close(f.traits.list[SOFT].mean, TRUE_MEAN, 30e-6);
        inside += f.traits.list[SOFT].low < TRUE_MEAN && TRUE_MEAN < f.traits.list[SOFT].high;
        for (int k = 0; k < TERMS; k++)
            if (k != SOFT) assert_true(f.traits.list[k].probability < 0.5);
        for (int a = 0; a < ARMS; a++) assert_true(f.arm[a].departure.probability < MUKCA_DEPARTS);
        mukca_fleet_free(&f);
    }
    assert_true(inside >= 17); /* of 20 at 95 %: fewer in one case of 60 */
}

/* Two coefficients that the data hardly distinguish, one of which is 0: the interval of the other
 * rests on that, and holds the truth. */
TEST(test_interval_is_not_too_wide)
{
    enum { FLEETS = 100, TWIN = SOFT + JOINTS };
    int inside = 0, named = 0;
    double width = 0, dense = 0;
    for (uint64_t seed = 1; seed <= FLEETS; seed++) {
        static mukca_summary s[ARMS];
        mukca_fleet f = {.n_arms = 0};
        mukca_random random = mukca_random_seeded(100 + seed);
        for (int a = 0; a < ARMS; a++) {
            const double own = TRUE_MEAN + TRUE_SPREAD * mukca_random_normal(&random),
                         sigma = 10e-6, same = 0.95;
            make_summary(&s[a], a, 0, sigma, &random);
            /* L = [1 same; same 1] / sigma^2, e = L c + noise of that covariance */
            const double x = mukca_random_normal(&random), y = mukca_random_normal(&random);
            s[a].information[mukca_fleet_packed(TWIN) + SOFT] = same / (sigma * sigma);
            s[a].vector[SOFT] = own / (sigma * sigma) + x / sigma;
            s[a].vector[SOFT + 1] -= 1e-3 / (sigma * sigma); /* surely not above 0 */
            s[a].vector[TWIN] =
                same * own / (sigma * sigma) + (same * x + sqrt(1 - same * same) * y) / sigma;
            take(&f, &s[a]);
        }
        assert_ok(mukca_fleet_gather(&f, NULL));
        assert_ok(mukca_fleet_pool(&f, &error));
        const mukca_trait *soft = &f.traits.list[SOFT];
        if (soft->probability > 0.5) {
            named++;
            inside += soft->low < TRUE_MEAN && TRUE_MEAN < soft->high;
            width += soft->high - soft->low;
            dense += 2 * 1.96 * soft->error;
        }
        for (int k = 0; k < TERMS; k++)
            assert_true(f.traits.list[k].low <= f.traits.list[k].value &&
                        f.traits.list[k].value <= f.traits.list[k].high &&
                        f.traits.list[k].high < 1e-3);
        assert_true(f.traits.list[SOFT + 1].probability < 0.1 &&
                    f.traits.list[SOFT + 1].value == 0);
        mukca_fleet_free(&f);
    }
    assert_true(named >= 95);
    assert_true(inside >= 0.9 * named); /* at 95 %, fewer in one case of 50 */
    assert_true(width < 0.6 * dense);
}

TEST(test_null_fleet)
{
    for (uint64_t seed = 1; seed <= 30; seed++) {
        mukca_fleet f;
        make_fleet(&f, 0, 0, seed);
        assert_ok(mukca_fleet_pool(&f, &error));
        for (int k = 0; k < TERMS; k++) assert_true(f.traits.list[k].probability < 0.95);
        for (int j = 0; j < JOINTS; j++) assert_int_equal(f.order[j].effect.variant.order, 0);
        mukca_fleet_free(&f);
    }
}

TEST(test_broken_arm)
{
    for (uint64_t seed = 1; seed <= 10; seed++) {
        mukca_fleet f;
        make_fleet(&f, TRUE_MEAN, 200e-6, seed);
        assert_ok(mukca_fleet_pool(&f, &error));
        for (int a = 0; a < ARMS; a++)
            assert_int_equal(f.arm[a].departure.probability >= MUKCA_DEPARTS, a == 7);
        assert_int_equal(f.arm[7].departure.effect.joint, SOFT);
        assert_true(f.arm[7].departure.ratio > 3 && f.arm[7].departure.ratio < 10);
        mukca_fleet_free(&f);
    }
}

/* Log Bayes factor of an order in one joint of the first arms, a penalty in the others, and of the
 * other orders that are not yet set. */
static void set_order(mukca_fleet *f, int joint, int order, int arms, double evidence)
{
    for (int s = 0; s < f->n_sessions; s++)
        for (int o = 0; o < MUKCA_FLEET_ORDERS; o++) {
            int16_t *quanta = &f->session[s]->ripple[joint][o];
            if (!*quanta) *quanta = (int16_t)(-2 / MUKCA_FLEET_QUANTUM);
        }
    for (int s = 0; s < f->n_sessions; s++)
        f->session[s]->ripple[joint][order - 2] =
            (int16_t)((s < arms ? evidence : -2) / MUKCA_FLEET_QUANTUM);
}

TEST(test_orders)
{
    mukca_fleet f;
    const mukca_trait *order = f.order;
    make_fleet(&f, 0, 0, 1);
    set_order(&f, 0, 160, ARMS, 3);  /* too faint for any one arm */
    set_order(&f, 1, 137, 1, 60);    /* one arm's own fault */
    set_order(&f, 2, 100, ARMS, -1); /* nothing */
    set_order(&f, 3, 239, 1, 60);    /* one arm reads a neighbour, */
    set_order(&f, 3, 240, ARMS, 10);
    set_order(&f, 4, 120, 1, 60); /* or half the order, far better */
    set_order(&f, 4, 240, ARMS, 10);
    mukca_orders_pool(&f);
    assert_int_equal(order[0].effect.variant.order, 160);
    assert_true(order[0].probability > 0.99);
    assert_close(order[0].log_bayes_factor, 36, 1e-9);
    assert_true(order[1].probability < 0.01);
    assert_true(order[2].probability < 0.5);
    for (int j = 3; j < 5; j++) {
        assert_int_equal(order[j].effect.variant.order, 240);
        assert_true(order[j].probability > 0.99);
    }
    mukca_fleet_free(&f);
}

/* Two sessions of one arm are that arm's data; the order of reading changes no bit. */
TEST(test_sessions_add_up)
{
    static mukca_summary s[6];
    mukca_random random = mukca_random_seeded(5);
    mukca_traits traits[2];
    for (int i = 0; i < 6; i++) {
        make_summary(&s[i], i, TRUE_MEAN, 10e-6, &random);
        if (i >= 4) memcpy(s[i].arm, s[0].arm, sizeof s[i].arm);
    }
    for (int turn = 0; turn < 2; turn++) {
        mukca_fleet f = {0};
        for (int i = 0; i < 6; i++) take(&f, &s[turn ? 5 - i : i]);
        assert_ok(mukca_fleet_gather(&f, NULL));
        assert_int_equal(f.n_arms, 4);
        assert_close(f.arm[0].information[mukca_fleet_packed(SOFT) + SOFT], 3e10, 1);
        assert_ok(mukca_fleet_pool(&f, &error));
        assert_int_equal(f.traits.n_samples, 600);
        traits[turn] = f.traits;
        mukca_fleet_free(&f);
    }
    assert_memory_equal(traits[0].list, traits[1].list, sizeof *traits[0].list * TERMS);
}

static void refuse(mukca_fleet *f, const mukca_summary *s, const char *what)
{
    assert_refused(mukca_fleet_take(f, s, &error), what);
}

TEST(test_what_cannot_be_pooled)
{
    static mukca_summary a, b;
    mukca_random random = mukca_random_seeded(5);
    mukca_fleet f = {0};
    make_summary(&a, 1, 0, 1e-5, &random);
    take(&f, &a);
    b = a, b.model.geometry++;
    refuse(&f, &b, "nominal geometry");
    b = a, b.model.masses++;
    refuse(&f, &b, "link masses");
    b = a, b.information[mukca_fleet_packed(1) + 0] = 1e12;
    refuse(&f, &b, "positive semidefinite");
    b = a, b.information[0] = -1;
    refuse(&f, &b, "positive semidefinite");
    mukca_fleet_free(&f);
}

TEST(test_file)
{
    static mukca_summary a;
    mukca_random random = mukca_random_seeded(5);
    mukca_fleet f = {0};
    make_summary(&a, 1, TRUE_MEAN, 1e-5, &random);
    for (int o = 0; o < MUKCA_FLEET_ORDERS; o++) a.ripple[1][o] = (int16_t)(o * 165 - 32767);
    a.model.geometry = UINT64_C(0xfedcba9876543210);
    const char *path;
    FILE *stream = scratch_create(&path, "a.json");
    assert_ok(mukca_summary_write(stream, &a, &error));
    fclose(stream);
    assert_ok(mukca_summary_read(&f, path, &error));
    assert_memory_equal(a.ripple, f.session[0]->ripple, JOINTS * sizeof *a.ripple);
    assert_memory_equal(&a.model, &f.model, sizeof a.model);
    for (int i = 0; i < TERMS; i++) assert_close(f.session[0]->vector[i], a.vector[i], 0);
    mukca_fleet_free(&f);
}

TEST_MAIN(scratch_setup, scratch_teardown)
