/* The decision: findings from posteriors made by hand, verdicts from findings.  A threshold can be
 * changed here with its consequences in view. */
#include "diagnose/cause.h"
#include "infer/findings.h"

#include "close.h"

enum { LOAD, ANGLE, TIME };                 /* families */
enum { COMPLIANCE, BENDING, BASE, RIPPLE }; /* effects */
enum { MOST = 8 };

static mukca_label labels[MOST];
static int n_labels;
static bool separate; /* positions show in different data */

typedef struct {
    mukca_labelled_set set[MOST];
    unsigned short member[MOST][MOST];
    double product[MOST][MOST * MOST];
    int n;
} posterior;

/* A label; effect -1: outside the catalogue. */
static int label(int family, int effect, int at, int detail)
{
    labels[n_labels] =
        (mukca_label){.family = family, .effect = effect, .from = at, .to = at, .detail = detail};
    return n_labels++;
}

/* A set of up to two causes (-1: none) that explain these squares each. */
static void add(posterior *p, double weight, int first, int second, double square)
{
    mukca_labelled_set *s = &p->set[p->n];
    *s = (mukca_labelled_set){.weight = weight,
                              .n = (first >= 0) + (second >= 0),
                              .label = p->member[p->n],
                              .product = p->product[p->n]};
    p->member[p->n][0] = (unsigned short)(first >= 0 ? first : 0);
    p->member[p->n][1] = (unsigned short)(second >= 0 ? second : 0);
    for (int i = 0; i < s->n; i++) p->product[p->n][i * s->n + i] = square;
    p->n++;
}

static mukca_labelled_sets of(const posterior *p)
{
    return (mukca_labelled_sets){n_labels, p->n, labels, p->set, MUKCA_FINDING_SQUARE, separate};
}

static posterior p, half[2]; /* empty at first */
static mukca_finding_group out[2 * MUKCA_MOST_FINDINGS];
static int all; /* findings and others */

/* Choose with the halves (0: with none); returns the number of findings. */
static int choose(int halves)
{
    mukca_pool pool = {0};
    mukca_labelled_sets whole = of(&p), parts[2] = {of(&half[0]), of(&half[1])};
    int n = -1;
    all = mukca_findings_choose(out, &n, &pool, &whole, parts, halves);
    mukca_pool_free(&pool);
    return n;
}

/* The halves are as the whole. */
static int choose_alike(void)
{
    half[0] = half[1] = p;
    return choose(2);
}

FIXTURE(setup)
{
    n_labels = 0;
    p = half[0] = half[1] = (posterior){.n = 0};
    return 0;
}

/* A name beside a larger function outside the catalogue is sure where both show in different data.
 */
TEST(separate_positions)
{
    const int name = label(LOAD, COMPLIANCE, 1, 0), other = label(ANGLE, -1, 4, 0);
    add(&p, 1, name, other, 50);
    p.product[0][3] = 500;
    assert_int_equal(choose_alike(), 2);
    for (int i = 0; i < 2; i++) assert_int_equal(out[i].kind, MUKCA_GROUP_FAMILY);
    separate = true;
    assert_int_equal(choose(2), 2);
    assert_int_equal(out[0].kind, MUKCA_GROUP_EFFECT);
    separate = false;
}

/* A mass at positions 4 and 5 and a gain at 2, or of all joints, share one signal and a declared
 * tie: nothing finer than the tie is sure. */
TEST(declared_tie)
{
    const int near = label(LOAD, BENDING, 4, 0), far = label(LOAD, BENDING, 5, 0),
              gain = label(TIME, BASE, 2, 0), common = label(TIME, BASE, 0, 0);
    for (int l = 0; l < n_labels; l++) labels[l].tie = 1;
    labels[common].apart = true;
    add(&p, 0.3, near, -1, 50);
    add(&p, 0.3, far, -1, 50);
    add(&p, 0.2, gain, -1, 50);
    add(&p, 0.2, common, -1, 50);
    assert_int_equal(choose_alike(), 1);
    assert_int_equal(out[0].kind, MUKCA_GROUP_TIE);
    assert_int_equal(out[0].from, 2);
    assert_int_equal(out[0].to, 5);
    for (int l = 0; l < n_labels; l++) labels[l].tie = 0;
    assert_int_equal(choose(2), 0);
}

/* Eight families at each of four positions: nothing that is sure is left out. */
TEST(many_findings)
{
    enum { FAMILIES = 8, MANY = 4 * FAMILIES };
    static unsigned short member[MANY];
    static double product[MANY * MANY];
    static mukca_label each[MANY];
    const mukca_labelled_set set = {1, MANY, member, product};
    const mukca_labelled_sets one = {MANY, 1, each, &set, MUKCA_FINDING_SQUARE, false};
    const mukca_labelled_sets halves[] = {one, one};
    mukca_pool pool = {0};
    int n = 0;
    for (int i = 0; i < MANY; i++) {
        const int family = i % FAMILIES, at = i / FAMILIES;
        each[i] = (mukca_label){.family = family, .effect = family, .from = at, .to = at};
        member[i] = (unsigned short)i;
        product[i * MANY + i] = 50;
    }
    mukca_findings_choose(out, &n, &pool, &one, halves, 2);
    mukca_pool_free(&pool);
    assert_int_equal(n, MANY);
}

/* Base, joint 0 and joint 1 share one signal: none is sure, a load from the base to joint 1 is. */
TEST(shared_signal)
{
    const int base = label(LOAD, BASE, -1, 0), first = label(LOAD, BENDING, 0, 0),
              second = label(LOAD, COMPLIANCE, 1, 0);
    add(&p, 0.4, base, -1, 50);
    add(&p, 0.3, first, -1, 50);
    add(&p, 0.29, second, -1, 50);
    add(&p, 0.01, -1, -1, 0);
    assert_int_equal(choose_alike(), 1);
    assert_int_equal(out[0].kind, MUKCA_GROUP_FAMILY);
    assert_int_equal(out[0].from, -1);
    assert_int_equal(out[0].to, 1);
    assert_close(out[0].probability, 0.99, 1e-12);
    assert_close(out[0].halves, 0.99, 1e-12);
}

/* One effect at one joint; its order is known within what the joint's travel resolves. */
TEST(exact)
{
    const int low = label(ANGLE, RIPPLE, 3, 100), high = label(ANGLE, RIPPLE, 3, 101),
              other = label(LOAD, COMPLIANCE, 1, 0);
    labels[low].blur = labels[high].blur = 1;
    labels[low].fine = labels[high].fine = true;
    add(&p, 0.6, low, other, 50);
    add(&p, 0.38, high, other, 50);
    add(&p, 0.02, other, -1, 50);
    assert_int_equal(choose_alike(), 2);
    assert_int_equal(out[0].kind, MUKCA_GROUP_DETAIL);
    assert_int_equal(out[0].effect, RIPPLE);
    assert_int_equal(out[1].kind, MUKCA_GROUP_EFFECT);
    assert_int_equal(out[1].effect, COMPLIANCE);
    const mukca_labelled_sets whole = of(&p);
    const double shares =
        mukca_finding_share(&out[0], &whole) + mukca_finding_share(&out[1], &whole);
    assert_close(shares, 1, 1e-12); /* they add up */
}

/* What a finer finding leaves: beside the sure cause there is another of the joint's angle, which
 * has one of two names.  If that is sure, too, and larger, it is said; else it shares its group
 * with a finding, or may be what that does not follow of its cause, and is no statement. */
TEST(left_by_finer)
{
    const int sure = label(ANGLE, RIPPLE, 2, 0), second = label(ANGLE, BASE, 2, 0),
              third = label(ANGLE, BENDING, 2, 0);
    add(&p, 0.4, sure, second, 50);
    add(&p, 0.4, sure, third, 50);
    add(&p, 0.2, sure, -1, 50);
    assert_int_equal(choose_alike(), 1);
    assert_int_equal(all, 1);
    p.n = 0;
    add(&p, 0.5, sure, second, 50);
    add(&p, 0.47, sure, third, 50);
    add(&p, 0.03, sure, -1, 50);
    for (int i = 0; i < 2; i++) p.product[i][3] = 100;
    assert_int_equal(choose_alike(), 2);
    assert_int_equal(out[0].effect, RIPPLE);
    assert_int_equal(out[1].kind, MUKCA_GROUP_FAMILY);
    assert_int_equal(out[1].n_finer, 1);
    assert_close(out[1].probability, 0.97, 1e-12);
    assert_close(out[1].halves, 0.97, 1e-12);
    assert_false(mukca_finding_holds(&out[1], &labels[sure]));
    assert_true(mukca_finding_holds(&out[1], &labels[third]));
    const mukca_labelled_sets whole = of(&p);
    assert_close(mukca_finding_share(&out[1], &whole), 0.97 * 2 / (0.97 * 2 + 1), 1e-12);
    for (int i = 0; i < 2; i++) p.product[i][3] = 40;
    assert_int_equal(choose_alike(), 1);
}

/* A name that is not sure enough is none in other words either: what its position varies with is
 * its name again, a stretch with the neighbour's cause in the other sets is not. */
TEST(name_in_other_words)
{
    const int name = label(LOAD, BENDING, 5, 0), neighbour = label(LOAD, COMPLIANCE, 4, 0);
    label(ANGLE, RIPPLE, 5, 0), label(ANGLE, COMPLIANCE, 5, 0), label(TIME, BASE, 5, 0);
    add(&p, 0.96, name, -1, 50); /* the other effects at its position are in no set */
    add(&p, 0.04, neighbour, -1, 50);
    assert_int_equal(choose_alike(), 1);
    assert_int_equal(out[0].kind, MUKCA_GROUP_FAMILY);
    assert_int_equal(out[0].from, 4);
    assert_int_equal(out[0].to, 5);
    p.n = 0;
    add(&p, 0.94, name, -1, 50);
    add(&p, 0.02, label(LOAD, COMPLIANCE, 5, 0), -1, 50);
    add(&p, 0.04, neighbour, -1, 50);
    assert_int_equal(choose_alike(), 1);
    assert_int_equal(out[0].kind, MUKCA_GROUP_FAMILY);
    assert_int_equal(out[0].from, 5);
}

/* A named and an unlisted function of one angle: it varies with that angle. */
TEST(outside_the_catalogue)
{
    const int named = label(ANGLE, RIPPLE, 2, 5), unlisted = label(ANGLE, -1, 2, 0);
    add(&p, 0.5, named, -1, 50);
    add(&p, 0.5, unlisted, -1, 50);
    assert_int_equal(choose_alike(), 1);
    assert_int_equal(out[0].kind, MUKCA_GROUP_FAMILY);
    assert_int_equal(out[0].family, ANGLE);
    assert_int_equal(out[0].effect, -1);
}

/* What exists and explains no more than noise is no finding; nor is what a half denies, nor what no
 * half was asked for. */
TEST(refused)
{
    const int cause = label(TIME, COMPLIANCE, 2, 0);
    add(&p, 1, cause, -1, MUKCA_FINDING_SQUARE - 1);
    assert_int_equal(choose_alike(), 0);
    assert_int_equal(all, 0);
    p.n = half[0].n = half[1].n = 0;
    add(&p, 1, cause, -1, 50);
    add(&half[0], 1, cause, -1, 50);
    add(&half[1], 1, -1, -1, 0);
    assert_int_equal(choose(2), 0);
    assert_int_equal(all, 1);
    assert_close(out[0].probability, 0.75, 1e-12);
    assert_int_equal(choose(0), 0);
    assert_true(isnan(out[0].halves));
}

/* A half in which another cause stands in its place counts against a finding, unless the whole has
 * that cause, too; a half with neither says nothing. */
TEST(rival_in_halves)
{
    const int cause = label(LOAD, COMPLIANCE, 2, 0), rival = label(ANGLE, RIPPLE, 3, 7);
    for (int common = 0; common < 2; common++) {
        p.n = half[0].n = half[1].n = 0;
        add(&p, 1, cause, common ? rival : -1, 50);
        add(&half[0], 0.9, cause, -1, 50);
        add(&half[0], 0.1, rival, -1, 50);
        half[1] = half[0];
        assert_int_equal(choose(2), common); /* 2.3 of 3 halves, and of 2.8 */
        assert_close(out[0].halves, 0.9, 1e-12);
        assert_close(out[0].against, common ? 0 : 0.1, 1e-12);
    }
}

/* Probability in the whole and in halves on either side of the thresholds. */
TEST(thresholds)
{
    static const struct {
        double whole, half;
        int findings, others, kind;
    } cases[] = {
        {0.991, 0.751, 1, 0, MUKCA_GROUP_EFFECT}, {0.989, 0.751, 1, 0, MUKCA_GROUP_PLACE},
        {0.951, 0.751, 1, 0, MUKCA_GROUP_PLACE},  {0.949, 0.751, 0, 1, MUKCA_GROUP_EFFECT},
        {0.951, 0.749, 0, 1, MUKCA_GROUP_EFFECT}, {0.501, 0.501, 0, 1, MUKCA_GROUP_EFFECT},
        {0.501, 0.301, 0, 0, MUKCA_GROUP_EFFECT}, {0.499, 0.999, 0, 0, MUKCA_GROUP_EFFECT}};
    const int cause = label(LOAD, COMPLIANCE, 2, 0);
    for (int i = 0; i < 8; i++) {
        p.n = half[0].n = 0;
        add(&p, cases[i].whole, cause, -1, 50);
        add(&half[0], cases[i].half, cause, -1, 50);
        half[1] = half[0];
        assert_int_equal(choose(2), cases[i].findings);
        assert_int_equal(all, cases[i].findings + cases[i].others);
        if (all) assert_int_equal(out[0].kind, cases[i].kind);
    }
}

/* Verdicts: of findings by their shares and the catalogue's part, without one by the sets. */
TEST(verdicts)
{
    static const struct {
        double share, outside;
        int effect, to, verdict;
    } cases[] = {{0.51, 0.9, MUKCA_EFFECT_JOINT_COMPLIANCE, 2, MUKCA_VERDICT_NAMED},
                 {0.49, 0.4, MUKCA_EFFECT_JOINT_COMPLIANCE, 2, MUKCA_VERDICT_TIED},
                 {0.90, 0.4, MUKCA_EFFECT_JOINT_COMPLIANCE, 3, MUKCA_VERDICT_TIED},
                 {0.90, 0.4, -1, 2, MUKCA_VERDICT_TIED},
                 {0.90, 0.6, -1, 2, MUKCA_VERDICT_UNKNOWN},
                 {0.90, 0.0, MUKCA_EFFECT_READBACK_LAG, 3, MUKCA_VERDICT_NAMED}};
    mukca_diagnosis *d = zeroed(1, sizeof *d);
    assert_int_equal(mukca_verdict_of(d, 0.94, 0.9), MUKCA_VERDICT_NONE);
    assert_int_equal(mukca_verdict_of(d, 0.96, 0.51), MUKCA_VERDICT_UNKNOWN);
    assert_int_equal(mukca_verdict_of(d, 0.96, 0.49), MUKCA_VERDICT_TIED);
    d->n_findings = 1;
    for (int i = 0; i < 6; i++) {
        d->findings[0] =
            (mukca_finding){.group = {.effect = cases[i].effect, .from = 2, .to = cases[i].to},
                            .share = cases[i].share,
                            .outside = cases[i].outside};
        assert_int_equal(mukca_verdict_of(d, 1, 1), cases[i].verdict);
    }
    free(d);
}

/* Groups are disjoint: a second finding shares no cause with the first. */
TEST(disjoint)
{
    const int a = label(LOAD, COMPLIANCE, 1, 0), b = label(LOAD, COMPLIANCE, 3, 0),
              c = label(LOAD, BENDING, 3, 0);
    add(&p, 0.5, a, b, 50);
    add(&p, 0.5, a, c, 50);
    assert_int_equal(choose_alike(), 2);
    for (int l = 0; l < n_labels; l++)
        assert_int_equal(
            mukca_finding_holds(&out[0], &labels[l]) + mukca_finding_holds(&out[1], &labels[l]), 1);
}

TEST_EACH(setup, NULL)
