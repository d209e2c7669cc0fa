/* The poses that settle a tie: within reach, in the recorded sockets, and telling. */
#include "diagnose/next_poses.h"

#include "arms.h"
#include "scene.h"

typedef struct {
    scene s;
    mukca_dataset data;
    mukca_diagnosis diagnosis;
    mukca_next_poses next;
} tie;

static tie recorded, *const t = &recorded;

static void set_tie(mukca_effect cause, mukca_effect rival)
{
    memset(t, 0, sizeof *t);
    set_scene(&t->s, NULL, 3);
    t->s.how.noise = 1e-4;
    t->s.how.rows = 8;
    record(&t->data, &t->s);
    mukca_diagnosis *d = &t->diagnosis;
    d->verdict = MUKCA_VERDICT_TIED;
    d->n_findings = 1;
    d->findings[0].n_alternatives = 2;
    d->findings[0].alternatives[0] =
        (mukca_alternative){.effect = cause, .listed = true, .probability = 0.6};
    d->findings[0].alternatives[1] =
        (mukca_alternative){.effect = rival, .listed = true, .probability = 0.4};
    d->geometry = t->s.arm.geometry;
    d->sigma_m = 1e-4;
}

static void choose(void)
{
    assert_ok(
        mukca_next_poses_choose(&t->next, &t->diagnosis, &t->s.chain, &t->data, NULL, &error));
}

static mukca_effect bending, scale, moved;

FIXTURE(setup)
{
    bending = make_effect(MUKCA_EFFECT_LINK_BENDING, 2, 4e-5);
    scale = make_effect(MUKCA_EFFECT_JOINT_SCALE, 1, 1e-3);
    moved = make_effect(MUKCA_EFFECT_TOOL_MOTION, -1, 1e-3);
    moved.placement = 0, moved.terms = 3;
    return 0;
}

TEST(poses_reach_their_sockets_and_tell)
{
    set_tie(bending, scale);
    choose();
    assert_int_equal(t->next.finding, 0);
    assert_int_equal(t->next.pair[1], 1);
    assert_int_equal(t->next.plan.n_rows, MUKCA_NEXT_POSES);
    assert_true(t->next.plan.evidence_after > 2 * t->next.plan.evidence_before);
    for (int i = 0; i < t->next.plan.n_rows; i++) {
        const mukca_plan_row *row = &t->next.plan.rows[i];
        const mukca_plan_socket *socket = &t->next.sockets[row->socket];
        double ball[3];
        mukca_fk_position(ball, &t->diagnosis.geometry, row->q, NULL);
        for (int a = 0; a < 3; a++) assert_close(ball[a], socket->centre[a], 1e-4);
        for (int j = 0; j < t->s.chain.n_joints; j++) {
            const mukca_element *e = &t->s.chain.element[t->s.chain.joint_element[j]];
            assert_true(row->q[j] >= e->lower && row->q[j] <= e->upper);
        }
    }
    mukca_plan_free(&t->next.plan);
    mukca_dataset_free(&t->data);
}

TEST(nothing_where_no_pose_can_settle_it)
{
    set_tie(scale, moved); /* a recording fault */
    choose();
    assert_int_equal(t->next.finding, -1);
    mukca_dataset_free(&t->data);

    set_tie(scale, scale);
    t->diagnosis.findings[0].n_alternatives = 1;
    choose();
    assert_int_equal(t->next.finding, -1);
    mukca_dataset_free(&t->data);

    set_tie(scale, bending);
    t->s.chain.n_masses = 0; /* nobody knows the load of other poses */
    choose();
    assert_int_equal(t->next.finding, 0);
    assert_int_equal(t->next.plan.n_rows, 0);
    mukca_plan_free(&t->next.plan);
    mukca_dataset_free(&t->data);
}

TEST_MAIN(setup, NULL)
