/* Searches of halves of the postures: what they draw, and that they find a cause of the whole. */
#include "diagnose/halves.h"
#include "diagnose/screening.h"
#include "scene.h"

typedef struct {
    mukca_dataset data;
    mukca_diagnosis diagnosis;
    mukca_diagnose_options options;
    mukca_regression m;
    mukca_search id;
    mukca_halves halves;
    mukca_pool pool;
} searched;

static scene s;

/* Search a recording and its halves. */
static void search(searched *of)
{
    const mukca_recording_options options = {.mass_spread = 0.1};
    assert_ok(mukca_regression_create(&of->m, &s.chain, &of->data, &options, &error));
    assert_true(mukca_screening_run(&of->diagnosis, &of->m));
    mukca_regression_fit(&of->m, 6, MUKCA_FIT_ALL);
    of->id = (mukca_search){.m = &of->m, .diagnosis = &of->diagnosis, .options = &of->options};
    assert_ok(mukca_identify_run(&of->id, &error));
    assert_ok(mukca_halves_search(&of->halves, &of->pool, &of->id, &error));
}

static void end(searched *of)
{
    mukca_halves_free(&of->halves);
    mukca_pool_free(&of->pool);
    mukca_identify_free(&of->id);
    mukca_diagnosis_free(&of->diagnosis);
    mukca_regression_free(&of->m);
    mukca_dataset_free(&of->data);
    free(of);
}

/* Log odds of the best set of a half; *soft: it has the compliance of the second joint. */
static double best_of(const searched *of, int half, bool *soft)
{
    const mukca_sets *sets = &of->halves.half[half].sets;
    const mukca_set *best = &sets->set[sets->best];
    *soft = false;
    for (int i = 0; i < best->n; i++) {
        const int candidate = of->id.kept[of->halves.item_of[best->item[i]]];
        const mukca_effect e = mukca_candidate_effect(&of->id.all.list[candidate]);
        *soft |= e.kind == MUKCA_EFFECT_JOINT_COMPLIANCE && e.joint == 1;
    }
    return best->value;
}

/* Each half finds the cause; a pair has all samples once; each half has its own means. */
TEST(halves_find_the_cause)
{
    searched *of = zeroed(1, sizeof *of);
    set_scene(&s, "joint_compliance:joint_2=2e-4", 7);
    s.how.noise = 1e-4;
    record(&of->data, &s);
    search(of);
    const mukca_recording *r = &of->m.recording;
    assert_int_equal(of->halves.n, MUKCA_HALVES);
    for (int h = 0; h < of->halves.n; h++) {
        bool soft;
        assert_true(best_of(of, h, &soft) > 0 && soft);
        const int both =
            of->halves.half[h].question.dof + of->halves.half[h ^ 1].question.dof - 2 * r->n_pairs;
        assert_int_equal(both, 3 * (r->n_samples - 2 * r->n_groups));
    }
    end(of);
}

/* The order of the rows does not matter. */
TEST(halves_do_not_know_the_order)
{
    searched *of[2] = {zeroed(1, sizeof **of), zeroed(1, sizeof **of)};
    set_scene(&s, "joint_compliance:joint_2=2e-4", 8);
    s.how.noise = 1e-4;
    for (int k = 0; k < 2; k++) record(&of[k]->data, &s);
    mukca_dataset *d = &of[1]->data;
    for (int i = 0, k = d->n_rows - 1; i < k; i++, k--) {
        double q[MUKCA_MAX_JOINTS], *a = d->q + i * d->n_joints, *b = d->q + k * d->n_joints;
        const size_t size = sizeof *q * (size_t)d->n_joints;
        const int socket = d->socket[i];
        memcpy(q, a, size), memcpy(a, b, size), memcpy(b, q, size);
        d->socket[i] = d->socket[k], d->socket[k] = socket;
    }
    for (int k = 0; k < 2; k++) search(of[k]);
    for (int h = 0; h < MUKCA_HALVES; h++) {
        bool soft[2];
        const double first = best_of(of[0], h, &soft[0]), second = best_of(of[1], h, &soft[1]);
        assert_true(soft[0] && soft[1]);
        assert_close(first, second, 1e-3 * first); /* sums in another order, and their fits */
    }
    for (int k = 0; k < 2; k++) end(of[k]);
}

/* A pair with too few postures in one half says nothing, whichever it is; the others do. */
TEST(halves_with_too_few)
{
    int before = 0;
    for (int seed = 1; seed <= 6; seed++) {
        searched *of = zeroed(1, sizeof *of);
        set_scene(&s, NULL, (uint64_t)seed);
        s.how.noise = 1e-4;
        s.how.rows = 3; /* of each socket's postures one or two are in a half */
        record(&of->data, &s);
        of->data.n_rows -= 2 * s.how.rows; /* three placements: 6 to 12 in a half, 8 at least */
        search(of);
        const mukca_half *half = of->halves.half;
        for (int pair = 1; pair < of->halves.n / 2; pair++)
            before += !half[2 * pair - 2].sets.n_sets && half[2 * pair].sets.n_sets;
        end(of);
    }
    assert_true(before > 0);
}

TEST_MAIN(NULL, NULL)
