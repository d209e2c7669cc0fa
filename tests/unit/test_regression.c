/* The mathematics under the diagnosis: columns against differences of predictions, scores of
 * candidates against evidence with their columns really added. */
#include "diagnose/held_out.h"
#include "diagnose/scan.h"
#include "diagnose/screening.h"
#include "math/stats.h"
#include "scene.h"

typedef struct {
    scene s;
    mukca_dataset data;
    mukca_regression m;
    mukca_candidates all;
    mukca_pool pool;
    mukca_scan scan;
} fixture;

static fixture *f;

static void create(void)
{
    const mukca_recording_options options = {.mass_spread = 0.1};
    assert_ok(mukca_regression_create(&f->m, &f->s.chain, &f->data, &options, &error));
    mukca_regression_fit(&f->m, 5, MUKCA_FIT_ALL);
    mukca_regression_freeze(&f->m);
    mukca_candidates_start(&f->all, &f->m.pool, &f->m.recording, NULL);
    assert_ok(mukca_candidates_list(&f->all, &f->m.unknowns, &error));
    assert_true(mukca_scan_create(&f->scan, &f->pool, &f->m, &f->all));
}

/* A recording of an arm with a soft joint. */
static void begin(void)
{
    f = zeroed(1, sizeof *f);
    set_scene(&f->s, "joint_compliance:joint_2=1e-4", 7);
    f->s.how.noise = 1e-4;
    record(&f->data, &f->s);
}

FIXTURE(set_up)
{
    begin();
    create();
    return 0;
}

FIXTURE(tear_down)
{
    mukca_regression_free(&f->m);
    mukca_dataset_free(&f->data);
    mukca_pool_free(&f->pool);
    free(f);
    return 0;
}

/* First candidate of that effect and joint. */
static const mukca_candidate *find(int effect, int joint)
{
    for (int i = 0; i < f->all.count; i++) {
        const mukca_candidate *h = &f->all.list[i];
        if (h->kind == MUKCA_CANDIDATE_EFFECT && h->joint == joint && (int)h->effect.kind == effect)
            return h;
    }
    fail_msg("no such candidate");
    return NULL;
}

/* The placements have one artefact: the error of its distance is one unknown, of which the prior of
 * the lengths alone knows anything, however many placements there are. */
TEST(one_error_of_the_distance)
{
    const mukca_unknowns *u = &f->m.unknowns;
    const double one = 1, sigma = mukca_distance_sigma(&f->data.distances[0]);
    assert_true(f->data.n_distances > 2 && u->n_geometry == u->first_artefact + 1);
    assert_true(mukca_regression_factor(&f->m) > -HUGE_VAL);
    const double error_m = mukca_regression_standard_error(&f->m, u->first_artefact, &one, 1);
    assert_true(error_m > 0.5 * sigma && error_m < sigma);
}

/* Columns of every effect that acts on the arm against differences of the forward model. */
TEST(effect_columns)
{
    mukca_regression *m = &f->m;
    int checked = 0;
    bool seen[MUKCA_EFFECT_COUNT] = {false}; /* each effect, and every seventh candidate */
    for (int i = 0; i < f->all.count; i++) {
        const mukca_candidate *h = &f->all.list[i];
        if (!mukca_candidate_moves_arm(h)) continue;
        const int kind = h->kind == MUKCA_CANDIDATE_EFFECT ? (int)h->effect.kind : -1;
        if (i % 7 && (kind < 0 || seen[kind])) continue;
        if (kind >= 0) seen[kind] = true;
        double *E = zeroed((size_t)(3 * m->recording.n_samples * h->terms), sizeof *E);
        mukca_linearisation_columns(E, h->terms, &m->linear, h);
        assert_true(mukca_unknowns_add(&m->unknowns, h));
        mukca_accepted *cause = &m->unknowns.cause[m->unknowns.n_causes - 1];
        for (int t = 0; t < h->terms; t++)
            for (int row = 0; row < m->recording.n_samples; row += 61) {
                double up[3], down[3];
                const double step = 1e-8 / h->unit[t]; /* rad or m */
                cause->coefficient[t] = step;
                mukca_unknowns_predict(up, &m->unknowns, &m->recording, m->recording.order[row]);
                cause->coefficient[t] = -step;
                mukca_unknowns_predict(down, &m->unknowns, &m->recording, m->recording.order[row]);
                cause->coefficient[t] = 0;
                for (int c = 0; c < 3; c++) {
                    const double slope = (up[c] - down[c]) / (2 * step);
                    /* levers are at the seated angles: some mm apart */
                    assert_close(E[(3 * row + c) * h->terms + t], slope,
                                 8e-3 * (fmax(1, 2 * h->unit[t]) + fabs(slope)));
                }
            }
        mukca_unknowns_drop(&m->unknowns, m->unknowns.n_causes - 1);
        free(E);
        checked++;
    }
    assert_true(checked > 50);
}

/* Log evidence of the present causes on the frozen columns, with the scale of the noise at its
 * maximum; mean[]: of the columns. */
static double evidence(mukca_regression *m, int family, double *mean, double *noise)
{
    mukca_regression_return(m);
    const mukca_normal_equations *normal = mukca_regression_collect(m, family);
    const int dof = normal->whitening.dof + normal->n_pairs;
    mukca_unknowns_prior(m->evidence.posterior.prior, &m->unknowns, -1);
    const double value = mukca_evidence_evaluate(&m->evidence, normal, m->unknowns.sigma, mean);
    assert_true(isfinite(value));
    *noise = m->evidence.posterior.quadratic / dof;
    return value + 0.5 * m->evidence.posterior.quadratic - 0.5 * dof * (log(*noise) + 1);
}

/* Log Bayes factor of a candidate whose columns are really added, averaged over its sizes. */
static double added(mukca_regression *m, int family, const mukca_candidate *h, double *mean)
{
    const mukca_mixture prior = mukca_candidate_mixture(h);
    const double one = 1;
    double value[MUKCA_MOST_SIZES], noise;
    const double without = evidence(m, family, mean, &noise);
    assert_true(mukca_unknowns_add(&m->unknowns, h));
    const int last = m->unknowns.n_causes - 1, column = mukca_unknowns_column(&m->unknowns, last);
    for (int s = 0; s < prior.n_sizes; s++) {
        m->unknowns.cause[last].scale = prior.size[s];
        value[s] = prior.log_weight[s] + evidence(m, family, mean, &noise) - without;
        if (!prior.nonnegative) continue;
        const double sigma = mukca_regression_standard_error(m, column, &one, 1);
        value[s] += log(2) + mukca_stats_log_normal_cdf(mean[column] / (sigma * sqrt(noise)));
    }
    mukca_unknowns_drop(&m->unknowns, last);
    return mukca_stats_log_sum_exp(value, prior.n_sizes);
}

/* Scores of the scan, of all kinds of candidates, and of the same as sets of one. */
static void check_scan(int family, const mukca_candidate *cause)
{
    enum { MOST = 120 };
    mukca_regression *m = &f->m;
    mukca_pool pool = {0};
    mukca_question question;
    mukca_sets sets;
    int pick[MOST], n = 0, seen[MUKCA_CANDIDATE_KINDS] = {0};
    bool tried[MUKCA_UNLISTED_FUNCTIONS] = {false};
    double mean[4096];
    assert_true(mukca_unknowns_capacity(&m->unknowns) < 4096);
    if (cause) {
        assert_true(mukca_unknowns_add(&m->unknowns, cause));
        m->unknowns.cause[0].scale = 1e-3;
    }
    assert_true(mukca_scan_aim(&f->scan, family));
    assert_ok(mukca_scan_run(&f->scan, &error));
    for (int i = 0; i < f->all.count && n < MOST; i++) {
        const mukca_candidate *h = &f->all.list[i];
        const bool first = h->kind == MUKCA_CANDIDATE_UNLISTED && !tried[h->unlisted.function];
        if (first) tried[h->unlisted.function] = true;
        if (!(f->scan.value[i] > -HUGE_VAL)) continue; /* a fault without a residual */
        if (seen[h->kind]++ % (h->kind == MUKCA_CANDIDATE_EFFECT ? 29 : 97) && !first) continue;
        if (!cause || !mukca_candidate_same(h, cause)) pick[n++] = i;
    }
    assert_in_range(n, 30, MOST - 1);
    for (int kind = 0; kind < MUKCA_CANDIDATE_KINDS; kind++) assert_true(seen[kind]);
    for (int k = 0; k < MUKCA_UNLISTED_FUNCTIONS; k++) /* springs are listed */
        assert_true(tried[k] || mukca_unlisted_functions[k].shape == MUKCA_SHAPE_SPRING);
    assert_true(mukca_scan_question(&question, &f->scan, &pool, pick, n));
    assert_true(mukca_sets_create(&sets, &pool, &question));
    for (int i = 0; i < n; i++) {
        const mukca_candidate *h = &f->all.list[pick[i]];
        const double value = f->scan.value[pick[i]];
        const int at = mukca_sets_insert(&sets, &i, NULL, 1);
        const double exact = added(m, family, h, mean);
        assert_true(at >= 0);
        /* rounding of differences of log evidences of some thousand */
        assert_close(sets.set[at].value, exact + h->log_prior - MUKCA_SET_RATE,
                     1e-6 * (1 + fabs(exact)));
        assert_close(value, exact, 1e-6 * (1 + fabs(exact)));
    }
    m->unknowns.n_causes = 0;
    mukca_pool_free(&pool);
}

TEST(scores)
{
    for (int family = 0; family < f->m.evidence.n_noises; family++)
        check_scan(family, family % 2 ? find(MUKCA_EFFECT_JOINT_COMPLIANCE, 1) : NULL);
}

/* With noise of the joint angles. */
TEST(scores_with_angles)
{
    mukca_evidence_set_share(&f->m.evidence, 3);
    check_scan(0, NULL);
    check_scan(1, find(MUKCA_EFFECT_JOINT_COMPLIANCE, 1));
}

/* Rows in pairs of nearly the same angles: also noise that readings of a posture share. */
TEST(repeated)
{
    fixture *const whole = f;
    begin();
    for (int row = 1; row < f->data.n_rows; row += 2)
        for (int j = 0; j < f->data.n_joints; j++)
            f->data.q[row * f->data.n_joints + j] =
                f->data.q[(row - 1) * f->data.n_joints + j] + 1e-5 * (row % 3 - 1);
    create();
    assert_true(f->m.recording.repeats);
    for (int family = 0; family < f->m.evidence.n_noises; family += 3) check_scan(family, NULL);
    for (int i = 0; i < f->all.count; i++) /* the tool moves between postures */
        if (f->all.list[i].kind == MUKCA_CANDIDATE_MOTION)
            assert_int_equal(f->all.list[i].fault.first % 2, 0);
    f->m.evidence.angular[1] = 5;
    mukca_evidence_set_share(&f->m.evidence, 2);
    check_scan(6, NULL);
    tear_down(NULL);
    f = whole;
}

/* Three sockets as a pose log, which has no free mean, and whose noise is not in the angles. */
TEST(poses)
{
    fixture *const whole = f;
    begin();
    f->data.position = zeroed(1, 3 * sizeof *f->data.position * (size_t)f->data.n_rows);
    for (int i = 0; i < 3 * f->data.n_rows; i++) f->data.position[i] = NAN;
    for (int row = 0; row < f->data.n_rows; row++) {
        if (f->data.socket[row] > 2) continue;
        f->data.socket[row] = -1;
        mukca_unknowns_predict(f->data.position + 3 * row, &whole->m.unknowns, &whole->m.recording,
                               row);
        f->data.position[3 * row + row % 3] += 1e-4 * (row % 5 - 2);
    }
    create();
    for (int family = 0; family < f->m.evidence.n_noises; family++) check_scan(family, NULL);
    mukca_recording *r = &f->m.recording;
    const size_t n = (size_t)r->chain->n_joints;
    mukca_recording_seat(r, &f->m.pool, f->m.linear.seated, f->m.linear.distance, 1);
    for (int row = 0; row < f->data.n_rows; row++)
        assert_int_equal(memcmp(r->q + (size_t)row * n, f->data.q + (size_t)row * n, n * 8) == 0,
                         f->data.socket[row] < 0);
    tear_down(NULL);
    f = whole;
}

/* Scores of all orders of ripple of a joint. */
TEST(orders)
{
    double value[MUKCA_LAST_ORDER + 1], mean[4096];
    for (int joint = 1; joint < 7; joint += 2) {
        const mukca_effect ripple = {.kind = MUKCA_EFFECT_GEAR_HARMONIC,
                                     .joint = joint,
                                     .placement = -1,
                                     .variant.order = 2};
        mukca_candidate h = mukca_candidate_of(&ripple);
        assert_true(mukca_candidate_prepare(&h, &f->m.pool, &f->m.recording));
        assert_true(mukca_scan_aim(&f->scan, 1));
        assert_true(mukca_scan_orders(value, &f->scan, &ripple));
        for (int order = 2; order <= MUKCA_LAST_ORDER; order += 57) {
            h.effect.variant.order = order;
            mukca_candidate_fill(&h, &f->m.recording);
            mukca_regression_freeze(&f->m); /* other columns of the same candidate */
            assert_close(value[order], added(&f->m, 1, &h, mean), 1e-6 * (1 + fabs(value[order])));
        }
    }
}

/* No noise has more evidence than the chosen one, whatever the guess. */
TEST(noise)
{
    mukca_regression *m = &f->m;
    mukca_unknowns_prior(m->evidence.posterior.prior, &m->unknowns, -1);
    for (int r = 0; r < m->evidence.n_noises; r++) {
        double value;
        mukca_normal_equations *normal = mukca_regression_collect(m, r);
        const double sigma = mukca_noise_choose(&m->evidence, normal, m->unknowns.sigma, &value);
        assert_close(mukca_evidence_evaluate(&m->evidence, normal, sigma, NULL), value,
                     1e-8 * fabs(value));
        for (int i = -1; i < 2; i += 2)
            assert_true(mukca_evidence_evaluate(&m->evidence, normal, sigma * (1 + 0.02 * i),
                                                NULL) < value);
        assert_close(mukca_noise_choose(&m->evidence, normal, 50 * sigma, NULL), sigma,
                     0.01 * sigma);
    }
}

/* As many causes as there is room for: their columns stay within it, and the geometry alone is
 * selected among them. */
TEST(full_columns)
{
    mukca_regression *m = &f->m;
    const int most = mukca_unknowns_capacity(&m->unknowns) + 1;
    int at = 0;
    while (at < f->all.count && (!f->all.list[at].basis || f->all.list[at].terms < 4 ||
                                 mukca_unknowns_add(&m->unknowns, &f->all.list[at])))
        at++;
    mukca_regression_freeze(m);
    assert_true(m->linear.n_columns + 1 > most - 32);
    assert_true(m->linear.stride == m->linear.n_columns + 1 && m->linear.stride <= most);
    const unsigned version = m->linear.version;
    m->unknowns.n_causes = 0;
    mukca_regression_return(m);
    assert_true(m->linear.version == version && m->linear.n_columns == m->unknowns.n_geometry);
    const double alone = mukca_regression_factor(m);
    mukca_regression_freeze(m);
    assert_true(m->linear.version != version && m->linear.stride == m->unknowns.n_geometry + 1);
    assert_close(mukca_regression_factor(m), alone, 1e-9 * fabs(alone)); /* rounding */
    mukca_regression_fit(m, 4, MUKCA_FIT_ALL);
}

/* The prior odds of all listed candidates and all orders sum to one, those of simple functions
 * outside the catalogue again to that of a class; flexible parts, which all arms have, have odds of
 * their own and leave their classes empty. */
TEST(priors)
{
    double orders = 0, sum = 0, simple = 0;
    int flexible = 0;
    for (int order = 2; order <= MUKCA_LAST_ORDER; order++)
        orders += mukca_effect_catalogue[MUKCA_EFFECT_GEAR_HARMONIC]->order_prior(order);
    assert_close(orders, 1, 1e-12);
    for (int i = 0; i < f->all.count; i++) {
        const mukca_candidate *h = &f->all.list[i];
        const int class = mukca_candidate_class(h);
        if (mukca_candidate_is_flexible(h))
            assert_close(h->log_prior, log(1.0 / 20), 1e-12);
        else if (class == MUKCA_CLASS_UNKNOWN && !mukca_unlisted_is_normalised(h)) {
            const bool wave =
                mukca_unlisted_functions[h->unlisted.function].shape == MUKCA_SHAPE_WAVE;
            if (!wave || h->unlisted.measure == 1) simple += exp(h->log_prior); /* as above */
        } else if (class != MUKCA_EFFECT_GEAR_HARMONIC)
            sum += exp(h->log_prior);
    }
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++)
        flexible += f->all.enabled[kind] && mukca_effect_has(kind, MUKCA_TRAIT_ELASTIC);
    /* few orders of ripple are listed */
    assert_close(sum + (1.0 + flexible) / f->all.classes, 1, 1e-9);
    assert_close(simple, 1.0 / f->all.classes, 1e-9);
}

/* How many springs by the load of a joint are outside the catalogue, with these effects excluded?
 */
static int springs_of_joints(const unsigned char *excluded)
{
    mukca_candidates all;
    mukca_pool pool = {0};
    int n = 0;
    mukca_candidates_start(&all, &pool, &f->m.recording, excluded);
    assert_ok(mukca_candidates_list(&all, &f->m.unknowns, &error));
    for (int i = 0; i < all.count; i++)
        n += all.list[i].kind == MUKCA_CANDIDATE_UNLISTED &&
             mukca_candidate_is_flexible(&all.list[i]) && all.list[i].terms == 1 &&
             all.list[i].unlisted.place == MUKCA_PLACE_ANGLE;
    mukca_pool_free(&pool);
    return n;
}

/* A spring is outside the catalogue where its effect is not listed. */
TEST(listed)
{
    int compliances = 0;
    for (int i = 0; i < f->all.count; i++)
        compliances += mukca_candidate_class(&f->all.list[i]) == MUKCA_EFFECT_JOINT_COMPLIANCE;
    assert_true(compliances > 1);
    assert_int_equal(springs_of_joints(NULL), f->s.chain.n_joints - compliances);
    const unsigned char excluded[MUKCA_EFFECT_COUNT] = {[MUKCA_EFFECT_JOINT_COMPLIANCE] = 1};
    assert_int_equal(springs_of_joints(excluded), f->s.chain.n_joints);
}

/* A function once per turn of a joint's own angle is outside the catalogue where eccentricity is
 * not listed, with the odds of bumps over that angle. */
TEST(own_angle)
{
    for (int without = 0; without < 2; without++) {
        const unsigned char excluded[MUKCA_EFFECT_COUNT] = {[MUKCA_EFFECT_ENCODER_ECCENTRICITY] =
                                                                (unsigned char)without};
        double wave[MUKCA_MAX_JOINTS] = {0}, bump[MUKCA_MAX_JOINTS] = {0};
        mukca_candidates all;
        mukca_pool pool = {0};
        int eccentricities = 0, waves = 0;
        mukca_candidates_start(&all, &pool, &f->m.recording, excluded);
        assert_ok(mukca_candidates_list(&all, &f->m.unknowns, &error));
        for (int i = 0; i < all.count; i++) {
            const mukca_candidate *h = &all.list[i];
            eccentricities += mukca_candidate_class(h) == MUKCA_EFFECT_ENCODER_ECCENTRICITY;
            if (h->kind != MUKCA_CANDIDATE_UNLISTED || h->unlisted.place != MUKCA_PLACE_ANGLE ||
                h->unlisted.argument != h->joint)
                continue;
            const mukca_unlisted_function *g = &mukca_unlisted_functions[h->unlisted.function];
            if (g->argument != MUKCA_ARGUMENT_ANGLE) continue;
            if (g->shape == MUKCA_SHAPE_WAVE) wave[h->joint] = h->log_prior, waves++;
            if (g->shape == MUKCA_SHAPE_BUMPS) bump[h->joint] = h->log_prior;
        }
        for (int j = 0; j < f->s.chain.n_joints; j++)
            if (wave[j] < 0 && bump[j] < 0) assert_close(wave[j], bump[j], 1e-12);
        assert_true(without ? !eccentricities && waves > 1 : eccentricities > 1);
        assert_true(without || eccentricities + waves == f->s.chain.n_joints);
        mukca_pool_free(&pool);
    }
}

/* A row cut as an outlier comes back when it fits; that it repeats the one before is told still. */
TEST(reinstated)
{
    enum { ROW = 5 };
    mukca_diagnosis *d = zeroed(1, sizeof *d);
    mukca_screening_add(d, &f->m.recording, MUKCA_FAULT_DUPLICATE, ROW, 0);
    mukca_screening_add(d, &f->m.recording, MUKCA_FAULT_OUTLIER, ROW, 0.1);
    f->m.recording.keep[ROW] = 0;
    mukca_recording_regroup(&f->m.recording);
    mukca_regression_fit(&f->m, 1, MUKCA_FIT_UNKNOWNS);
    assert_int_equal(mukca_screening_reinstate(d, &f->m), 1);
    assert_true(f->m.recording.keep[ROW]);
    assert_int_equal(d->n_faults, 1);
    assert_int_equal(d->faults[0].kind, MUKCA_FAULT_DUPLICATE);
    free(d);
}

/* Two poses beside sockets are too few for folds of their own: they are always fitted, and so no
 * error of theirs is a left-out one. */
TEST(never_left_out)
{
    enum { POSES = 2 };
    const mukca_recording_options options = {.mass_spread = 0.1};
    mukca_dataset data;
    mukca_regression m;
    record(&data, &f->s);
    data.position = zeroed(1, 3 * sizeof *data.position * (size_t)data.n_rows);
    for (int i = 0; i < 3 * data.n_rows; i++) data.position[i] = NAN;
    for (int row = 0; row < POSES; row++) {
        data.socket[row] = -1;
        mukca_unknowns_predict(data.position + 3 * row, &f->m.unknowns, &f->m.recording, row);
    }
    assert_ok(mukca_regression_create(&m, &f->s.chain, &data, &options, &error));
    mukca_regression_fit(&m, 3, MUKCA_FIT_ALL);
    mukca_folds b = {.m = &m};
    mukca_folds_create(&b);
    assert_false(m.pool.failed);
    for (int i = 0; i < 3 * data.n_rows; i++) b.position[i] = 1; /* what came before */
    mukca_folds_run(b.error, &b, false);
    for (int row = 0; row < data.n_rows; row++)
        assert_int_equal(isfinite(b.error[row]) != 0, row >= POSES);
    mukca_regression_free(&m);
    mukca_dataset_free(&data);
}

/* The chosen scales of the geometry have the largest evidence of all. */
TEST(scales)
{
    mukca_regression *m = &f->m;
    mukca_unknowns *u = &m->unknowns;
    double worst = HUGE_VAL;
    mukca_scales_choose(m, mukca_regression_collect(m, u->family));
    const double best = mukca_regression_factor(m);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++) {
            static const double angles[] = {1e-3, 2.5e-3, 5e-3, 10e-3};
            u->prior.length = 0.5e-3 * (1 << i), u->prior.angle = angles[k];
            mukca_unknowns_set_geometry_prior(u, &m->recording);
            const double value = mukca_regression_factor(m);
            assert_true(value <= best + 1e-9);
            worst = fmin(worst, value);
        }
    assert_true(worst < best - 0.1); /* the grid makes a difference */
    mukca_regression_fit(m, 5, MUKCA_FIT_ALL);
}

/* Log density of Student's noise in space, four degrees of freedom, of a squared length in sigma^2;
 * without -3 log(sigma). */
static double student(double square)
{
    const double nu = 4;
    return lgamma(0.5 * (nu + 3)) - lgamma(0.5 * nu) - 1.5 * log(nu * M_PI) -
           0.5 * (nu + 3) * log1p(square / nu);
}

/* The weighted Gaussian touches Student's density from below; it is chosen where some samples are
 * far off, which then have small weights, and not for Gaussian noise. */
TEST(tails)
{
    mukca_regression *m = &f->m;
    const mukca_recording *r = &m->recording;
    const int n = m->linear.n_columns, rows = f->data.n_rows;
    double *weight = zeroed((size_t)rows, sizeof *weight), sum = 0;
    mukca_regression_choose_tails(m, weight);
    assert_null(m->unknowns.tails);

    const double sigma = m->unknowns.sigma;
    for (int row = 0; row < rows; row++) weight[row] = 1;
    const double gain = mukca_evidence_weigh_tails(weight, &m->evidence, sigma);
    for (int g = 0; g < r->n_groups; g++) {
        double mean[3] = {0}, y[3];
        for (int pass = 0; pass < 2; pass++)
            for (int i = r->groups[g].start; i < r->groups[g].start + r->groups[g].count; i++) {
                double square = 0;
                for (int c = 0; c < 3; c++) {
                    const double *x = m->linear.columns + (3 * i + c) * m->linear.stride;
                    y[c] = x[m->linear.y];
                    for (int k = 0; k < n; k++) y[c] -= x[k] * m->evidence.mean[k];
                    if (pass == 0) mean[c] += y[c] / r->groups[g].count;
                    square += pow((y[c] - mean[c]) / sigma, 2);
                }
                if (pass == 0) continue;
                const double w = pow(weight[r->order[i]], 2);
                assert_close(w, 7 / (4 + square), 1e-9);
                sum += student(square) + 1.5 * log(2 * M_PI) + 0.5 * w * square;
                for (double other = 0; other < 100; other += 0.5)
                    assert_true(student(other) >=
                                student(square) - 0.5 * w * (other - square) - 1e-12);
            }
    }
    assert_close(gain, sum, 1e-8);

    mukca_dataset data;
    mukca_regression heavy;
    const mukca_recording_options options = {.mass_spread = 0.1};
    record(&data, &f->s);
    for (int row = 4; row < rows; row += 9) data.q[row * data.n_joints] += row % 2 ? 2e-3 : -2e-3;
    assert_ok(mukca_regression_create(&heavy, &f->s.chain, &data, &options, &error));
    mukca_regression_fit(&heavy, 5, MUKCA_FIT_ALL);
    mukca_regression_freeze(&heavy);
    mukca_regression_choose_tails(&heavy, weight);
    assert_ptr_equal(heavy.unknowns.tails, weight);
    double off = 0, all = 0; /* some sockets are near the axis: means */
    for (int row = 0; row < rows; row++) all += weight[row] / rows;
    for (int row = 4; row < rows; row += 9) off += weight[row] / 27;
    assert_int_equal(rows, 240);
    assert_true(off < 0.5 * all);
    mukca_regression_free(&heavy);
    mukca_dataset_free(&data);
    free(weight);
}

/* A fit is the mean over its models, each with some of the causes, and remains so when a cause is
 * dropped. */
TEST(models_are_averaged)
{
    enum { FIRST, SECOND, BOTH };
    mukca_regression *m = &f->m;
    mukca_unknowns *u = &m->unknowns;
    double *mean[3];
    for (int i = 0; i < f->all.count && u->n_causes < 2; i++)
        if (f->all.list[i].kind == MUKCA_CANDIDATE_EFFECT && f->all.list[i].terms == 1 &&
            f->all.list[i].joint == 1 + u->n_causes)
            assert_true(mukca_unknowns_add(u, &f->all.list[i]));
    assert_int_equal(u->n_causes, 2);
    mukca_regression_linearise(m);
    const mukca_normal_equations *normal = mukca_regression_collect(m, u->family);
    const int n = mukca_unknowns_column(u, 2);
    u->model[FIRST] = 1, u->model[SECOND] = 2, u->model[BOTH] = 3;
    for (int k = 0; k < 3; k++) {
        mean[k] = zeroed((size_t)n, sizeof(double));
        assert_true(mukca_regression_solve(m, normal, k));
        memcpy(mean[k], m->evidence.mean, sizeof(double) * (size_t)n);
    }
    assert_true(mean[FIRST][n - 1] == 0 && mean[SECOND][n - 2] == 0); /* what a model lacks */
    assert_true(mean[BOTH][n - 1] != 0 && mean[BOTH][n - 2] != 0);
    u->n_models = 3;
    u->model_weight[FIRST] = 0.2, u->model_weight[SECOND] = 0.3, u->model_weight[BOTH] = 0.5;
    assert_true(mukca_regression_average(m, normal));
    for (int i = 0; i < n; i++) /* rounding of three products */
        assert_close(m->evidence.mean[i],
                     0.2 * mean[FIRST][i] + 0.3 * mean[SECOND][i] + 0.5 * mean[BOTH][i], 1e-15);
    mukca_unknowns_drop(u, 0);
    assert_true(u->model[FIRST] == 0 && u->model[SECOND] == 1 && u->model[BOTH] == 1);
    mukca_regression_linearise(m);
    assert_true(mukca_regression_average(m, mukca_regression_collect(m, u->family)));
    /* without the first cause, BOTH is SECOND; the same columns */
    assert_close(m->evidence.mean[n - 2], 0.8 * mean[SECOND][n - 1],
                 1e-9 * fabs(mean[SECOND][n - 1]));
    for (int k = 0; k < 3; k++) free(mean[k]);
}

TEST_MAIN(set_up, tear_down)
