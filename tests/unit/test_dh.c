/* Denavit-Hartenberg tables: published ones are found, those of random arms are exact. */
#include "io/export.h"

#include "arms.h"
#include "base/number.h"
#include "close.h"
#include "math/random.h"

static const double half = 1.57079632679489661923, pi = 3.14159265358979323846;

/* a, alpha, d, theta of the rows of an exported table, and the types of their joints. */
typedef struct {
    int n_rows;
    double row[10][4];
    char type[10][16];
} table;

static void export(table *t, const mukca_chain *arm, const mukca_export_format *format)
{
    static mukca_offsets nominal;
    const mukca_export_input input = {.urdf_path = "x", .chain = arm, .offsets = &nominal};
    char *text = NULL;
    size_t size;
    FILE *stream = open_memstream(&text, &size);
    mukca_offsets_init(&nominal, arm);
    assert_ok(format->write(stream, &input));
    fclose(stream);
    t->n_rows = 0;
    for (char *line = strstr(text, "upper\n") + 6, *end; *line; line = end + 1) {
        char number[4][32];
        end = strchr(line, '\n');
        assert_true(t->n_rows < 10);
        assert_int_equal(sscanf(line, "%*s %15s %31s %31s %31s %31s", t->type[t->n_rows], number[0],
                                number[1], number[2], number[3]),
                         5);
        for (int i = 0; i < 4; i++)
            assert_true(mukca_number_parse(&t->row[t->n_rows][i], number[i]));
        t->n_rows++;
    }
    free(text);
}

static void check_rows(const table *t, const double (*wanted)[4], int n)
{
    assert_int_equal(t->n_rows, n);
    for (int k = 0; k < n; k++)
        for (int i = 0; i < 4; i++) assert_close(t->row[k][i], wanted[k][i], 1e-12);
}

/* The origins of Universal Robots' UR5e description against the table that they publish
 * (a, alpha, d, theta; "DH parameters for calculations of kinematics and dynamics"). */
TEST(finds_table_of_ur5e)
{
    static const double origin[6][6] = {{0, 0, 0.1625, 0, 0, 0},     {0, 0, 0, half, 0, 0},
                                        {-0.425, 0, 0, 0, 0, 0},     {-0.3922, 0, 0.1333, 0, 0, 0},
                                        {0, -0.0997, 0, half, 0, 0}, {0, 0.0996, 0, half, pi, pi}};
    static const double wanted[6][4] = {{0, half, 0.1625, 0},  {-0.425, 0, 0, 0},
                                        {-0.3922, 0, 0, 0},    {0, half, 0.1333, 0},
                                        {0, -half, 0.0997, 0}, {0, 0, 0.0996, 0}};
    mukca_chain chain;
    table t;
    make_chain(&chain, "RRRRRR", origin, "j", pi);
    export(&t, &chain, &mukca_export_dh);
    check_rows(&t, wanted, 6);
}

/* The origins of Franka's description against the modified table of their documentation. */
TEST(finds_table_of_panda)
{
    static const double origin[8][6] = {
        {0, 0, 0.333, 0, 0, 0},           {0, 0, 0, -half, 0, 0},
        {0, -0.316, 0, half, 0, 0},       {0.0825, 0, 0, half, 0, 0},
        {-0.0825, 0.384, 0, -half, 0, 0}, {0, 0, 0, half, 0, 0},
        {0.088, 0, 0, half, 0, 0},        {0, 0, 0.107, 0, 0, 0}};
    static const double wanted[7][4] = {
        {0, 0, 0.333, 0},           {0, -half, 0, 0}, {0, half, 0.316, 0},    {0.0825, half, 0, 0},
        {-0.0825, -half, 0.384, 0}, {0, half, 0, 0},  {0.088, half, 0.107, 0}};
    mukca_chain chain;
    table t;
    make_chain(&chain, "RRRRRRRF", origin, "j", pi);
    export(&t, &chain, &mukca_export_mdh);
    check_rows(&t, wanted, 7);
}

/* The tip of a table by its published formula, written out here. */
static void tip_of(double p[3], const table *t, bool modified, const double *q)
{
    mukca_frame T = {.R = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    for (int k = 0, j = 0; k < t->n_rows; k++) {
        const double *r = t->row[k], move = strcmp(t->type[k], "fixed") == 0 ? 0 : q[j++];
        const bool slides = strcmp(t->type[k], "prismatic") == 0;
        const double theta = r[3] + (slides ? 0 : move), d = r[2] + (slides ? move : 0);
        const double c = cos(theta), s = sin(theta), ca = cos(r[1]), sa = sin(r[1]);
        const mukca_frame turn = {.R = {c, -s, 0, s, c, 0, 0, 0, 1}, .p = {0, 0, d}};
        const mukca_frame bend = {.R = {1, 0, 0, 0, ca, -sa, 0, sa, ca}, .p = {r[0], 0, 0}};
        mukca_frame_multiply(&T, &T, modified ? &bend : &turn);
        mukca_frame_multiply(&T, &T, modified ? &turn : &bend);
    }
    memcpy(p, T.p, sizeof T.p);
}

/* Axes in any direction, parallel and meeting ones, prismatic joints, fixed elements between. */
TEST(table_of_random_arms_is_exact)
{
    mukca_random random = mukca_random_seeded(5);
    for (int arm = 0; arm < 200; arm++) {
        double origin[8][6], q[8], p[3], r[3];
        mukca_chain chain;
        table t;
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
            export(&t, &chain, c ? &mukca_export_mdh : &mukca_export_dh);
            tip_of(r, &t, c, q);
            assert_close(mukca_distance3(p, r), 0, 1e-9);
        }
    }
}

TEST_MAIN(NULL, NULL)
