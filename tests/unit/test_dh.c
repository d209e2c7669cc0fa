/* Denavit-Hartenberg tables: published ones are found, those of random arms are exact. */
#include "model/dh.h"

#include "arms.h"
#include "close.h"
#include "math/random.h"

static const double half = 1.57079632679489661923, pi = 3.14159265358979323846;

static void check_rows(const mukca_dh *dh, const double (*wanted)[4], int n)
{
    assert_int_equal(dh->n_rows, n);
    for (int k = 0; k < n; k++) {
        assert_close(dh->row[k].a, wanted[k][0], 1e-12);
        assert_close(dh->row[k].alpha, wanted[k][1], 1e-12);
        assert_close(dh->row[k].d, wanted[k][2], 1e-12);
        assert_close(dh->row[k].theta, wanted[k][3], 1e-12);
    }
}

/* The origins of Universal Robots' UR5e description against the table that they publish
 * (a, alpha, d, theta; "DH parameters for calculations of kinematics and dynamics"). */
TEST(finds_table_of_ur5e)
{
    static const double origin[6][6] = {{0, 0, 0.1625, 0, 0, 0},     {0, 0, 0, half, 0, 0},
                                        {-0.425, 0, 0, 0, 0, 0},     {-0.3922, 0, 0.1333, 0, 0, 0},
                                        {0, -0.0997, 0, half, 0, 0}, {0, 0.0996, 0, half, pi, pi}};
    static const double table[6][4] = {{0, half, 0.1625, 0},  {-0.425, 0, 0, 0},
                                       {-0.3922, 0, 0, 0},    {0, half, 0.1333, 0},
                                       {0, -half, 0.0997, 0}, {0, 0, 0.0996, 0}};
    mukca_chain chain;
    mukca_dh dh;
    make_chain(&chain, "RRRRRR", origin, "j", pi);
    mukca_dh_from_chain(&dh, &chain, NULL, MUKCA_DH_STANDARD);
    check_rows(&dh, table, 6);
}

/* The origins of Franka's description against the modified table of their documentation. */
TEST(finds_table_of_panda)
{
    static const double origin[8][6] = {
        {0, 0, 0.333, 0, 0, 0},           {0, 0, 0, -half, 0, 0},
        {0, -0.316, 0, half, 0, 0},       {0.0825, 0, 0, half, 0, 0},
        {-0.0825, 0.384, 0, -half, 0, 0}, {0, 0, 0, half, 0, 0},
        {0.088, 0, 0, half, 0, 0},        {0, 0, 0.107, 0, 0, 0}};
    static const double table[7][4] = {
        {0, 0, 0.333, 0},           {0, -half, 0, 0}, {0, half, 0.316, 0},    {0.0825, half, 0, 0},
        {-0.0825, -half, 0.384, 0}, {0, half, 0, 0},  {0.088, half, 0.107, 0}};
    mukca_chain chain;
    mukca_dh dh;
    make_chain(&chain, "RRRRRRRF", origin, "j", pi);
    mukca_dh_from_chain(&dh, &chain, NULL, MUKCA_DH_MODIFIED);
    check_rows(&dh, table, 7);
}

/* The tip of a table by its published formula, written out here. */
static void tip_of(double p[3], const mukca_dh *dh, const double *q)
{
    mukca_frame T = {.R = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    for (int k = 0, j = 0; k < dh->n_rows; k++) {
        const mukca_dh_row *r = &dh->row[k];
        const double move = r->type == MUKCA_FIXED ? 0 : q[j++];
        const double theta = r->theta + (r->type == MUKCA_PRISMATIC ? 0 : move);
        const double d = r->d + (r->type == MUKCA_PRISMATIC ? move : 0);
        const double c = cos(theta), s = sin(theta), ca = cos(r->alpha), sa = sin(r->alpha);
        const mukca_frame turn = {.R = {c, -s, 0, s, c, 0, 0, 0, 1}, .p = {0, 0, d}};
        const mukca_frame bend = {.R = {1, 0, 0, 0, ca, -sa, 0, sa, ca}, .p = {r->a, 0, 0}};
        const bool modified = dh->convention == MUKCA_DH_MODIFIED;
        mukca_frame_multiply(&T, &T, modified ? &bend : &turn);
        mukca_frame_multiply(&T, &T, modified ? &turn : &bend);
    }
    memcpy(p, T.p, sizeof T.p);
}

/* Axes in any direction, parallel and meeting ones, prismatic joints, fixed elements between. */
TEST(table_of_random_arms_is_exact)
{
    mukca_random random;
    mukca_random_seed(&random, 5);
    for (int arm = 0; arm < 200; arm++) {
        double origin[8][6], q[8], p[3], r[3];
        mukca_chain chain;
        mukca_dh dh;
        mukca_geometry geometry;
        for (int k = 0; k < 8; k++)
            for (int i = 0; i < 6; i++)
                origin[k][i] = mukca_random_below(&random, 3) ? 0.5 * mukca_random_normal(&random)
                               : i == 3                       ? half
                                                              : 0;
        make_chain(&chain, "RRRRRRRF", (const double(*)[6])origin, "j", pi);
        for (int k = 0; k < 7; k++) {
            mukca_element *e = &chain.element[k];
            if (mukca_random_below(&random, 4) == 0) e->type = MUKCA_PRISMATIC;
            if (mukca_random_below(&random, 3) == 0) e->axis[2] = -1;
            if (mukca_random_below(&random, 3) == 0) e->axis[0] = 0.6, e->axis[2] = 0.8;
            q[k] = mukca_random_normal(&random);
        }
        mukca_geometry_set(&geometry, &chain, NULL);
        mukca_fk_position(p, &geometry, q, NULL);
        for (int c = 0; c < 2; c++) {
            mukca_dh_from_chain(&dh, &chain, NULL, (mukca_dh_convention)c);
            tip_of(r, &dh, q);
            assert_close(mukca_distance3(p, r), 0, 1e-9);
        }
    }
}

TEST_MAIN(NULL, NULL)
