/* Datasets: folders, sessions and pose logs, in any mixture, and what is wrong with them. */
#include "io/dataset.h"

#include "arms.h"
#include "model/dataset_subset.h"
#include "scratch.h"

static mukca_chain chain;
static mukca_dataset data;

static mukca_status load(const char *const *paths, int n, const mukca_dataset_options *options)
{
    notes[0] = error.text[0] = '\0';
    mukca_dataset_free(&data);
    mukca_dataset_options noted = options ? *options : (mukca_dataset_options){0};
    noted.notes.write = note;
    return mukca_dataset_load(&data, &chain, paths, n, &noted, &error);
}

static mukca_status load_one(const char *path, const mukca_dataset_options *options)
{
    return load(&path, 1, options);
}

/* A text, and its format (NULL: the usual one). */
typedef struct {
    const char *text;
    const mukca_rows_format *format;
} table;

/* A table of that text, in a format (NULL: the usual one). */
static mukca_status load_text(const char *text, const mukca_rows_format *format)
{
    mukca_dataset_options options = {0};
    if (format) options.format = *format;
    return load_one(scratch_file("t.csv", text), &options);
}

/* A folder of the published kind; its path. */
static const char *folder(const char *name, const char *hole_0, const char *hole_1)
{
    char file[128];
    snprintf(file, sizeof file, "%s/hole_0.csv", name);
    scratch_file(file, hole_0);
    snprintf(file, sizeof file, "%s/hole_1.csv", name);
    if (hole_1) scratch_file(file, hole_1);
    return scratch_path(name);
}

/* Two revolute joints, z and y, links of 0.3 and 0.2 m. */
static int setup(void **state)
{
    static const double links[3][6] = {{0}, {0.3}, {0.2}};
    make_chain(&chain, "RRF", links, "j", 3);
    chain.element[1].axis[1] = 1, chain.element[1].axis[2] = 0;
    return scratch_setup(state);
}

static int teardown(void **state)
{
    mukca_dataset_free(&data);
    return scratch_teardown(state);
}

TEST(folders_and_sessions_mix)
{
    const char *paths[] = {
        folder("front", "0.1,0.2\n0.3,0.4\n0.5,0.6\n", "-1,2\n1,-2\n"),
        scratch_file("s.tsv",
                     "# robot: x\nplacement\tsocket\ttime_s\tj2\tj1\tj1.effort\tj2.effort\n"
                     "low\tA\t10\t0.2\t0.1\t5\t6\nlow\tB\t11\t0.4\t0.3\t7\t8\n"
                     "low\tA\t12\t0.6\t0.5\t\t9\nlow\tB\t13\t0.8\t0.7\t1\tnan\n"),
        scratch_file("log.csv", "j1,j2,x_m,y_m,z_m\n1,2,0.1,0.2,0.3\n1,2,,,\n")};
    assert_ok(load(paths, 3, NULL));
    assert_part(notes, "log.csv: 1 of 2 rows ignored: no measured position");
    assert_int_equal(data.n_rows, 10);
    assert_int_equal(data.n_placements, 2);
    assert_int_equal(data.n_sockets, 4);
    assert_int_equal(data.n_files, 4);
    assert_int_equal(data.n_distances, 2);
    assert_string_equal(data.placements[0].name, "front");
    assert_string_equal(data.placements[1].name, "low");
    assert_string_equal(data.sockets[1].label, "1");
    assert_string_equal(data.sockets[2].label, "A");
    assert_close(data.distances[1].distance, 0.05, 0);
    assert_int_equal(data.distances[1].a, 2);
    assert_int_equal(data.distances[1].b, 3);
    /* recording order, the chain's joint order */
    static const int socket[] = {0, 0, 0, 1, 1, 2, 3, 2, 3, -1};
    static const int row[] = {1, 2, 3, 1, 2, 1, 2, 3, 4, 1};
    for (int i = 0; i < 10; i++) {
        assert_int_equal(data.socket[i], socket[i]);
        assert_int_equal(data.row[i], row[i]);
    }
    assert_true(data.q[2 * 7] == 0.5 && data.q[2 * 7 + 1] == 0.6);
    assert_true(isnan(data.time[0]) && data.time[8] == 13);
    assert_true(isnan(data.effort[2 * 4]) && data.effort[2 * 5] == 5);
    assert_true(isnan(data.effort[2 * 7]) && data.effort[2 * 7 + 1] == 9);
    assert_true(isnan(data.effort[2 * 8 + 1]));
    assert_true(isnan(data.position[0]) && data.position[3 * 9 + 2] == 0.3);
    assert_null(data.quaternion);
    assert_null(data.payload);
    assert_int_equal(mukca_dataset_placement(&data, 5), 1);
    assert_int_equal(mukca_dataset_placement(&data, 9), -1);
}

TEST(equal_names_stay_apart)
{
#define FOUR(x) \
    "placement\tsocket\tj1\tj2\np\t0\t0\t" x "\np\t1\t0\t" x "\np\t0\t1\t" x "\np\t1\t1\t" x "\n"
    const char *paths[] = {folder("p", "0,0\n1,1\n", "0,0\n1,1\n"),
                           scratch_file("a.tsv", FOUR("2")), scratch_file("b.tsv", FOUR("3")),
                           scratch_file("c/b.tsv", FOUR("4"))};
    assert_ok(load(paths, 4, NULL));
    assert_int_equal(data.n_placements, 4);
    assert_int_equal(data.n_rows, 16);
    assert_string_equal(data.placements[0].name, "p");
    assert_string_equal(data.placements[1].name, "a:p");
    assert_string_equal(data.placements[2].name, "b:p");
    assert_string_equal(data.placements[3].name, "p#2");
    assert_part(notes, "already");
    for (int s = 0; s < 8; s++) assert_int_equal(data.sockets[s].placement, s / 2);
}

/* A copy has another name, columns that lack, and rows of its own; times tell readings apart. */
TEST(copies_are_used_once)
{
    const char *first =
        "placement\tsocket\tj1\tj2\ttime_s\np\t0\t0\t0\t1\np\t0\t0\t0\t2\n"
        "p\t1\t1\t0\t3\np\t1\t1\t1\t4\np\t1\t1\t1\t4\n";
    const char *copy =
        "placement\tsocket\tj1\tj2\nq\t0\t0\t0\nq\t1\t1\t0\nq\t0\t1\t1\nq\t1\t1\t1\n"
        "q\t0\t2\t1\nr\t0\t0\t0\nr\t1\t1\t0\n";
    const char *paths[] = {scratch_file("a.tsv", first), scratch_file("b.tsv", copy)};
    const mukca_dataset_options partial = {.partial = true};
    assert_ok(load(paths, 2, NULL));
    assert_part(notes,
                "placement 'q': only one socket; at least two, a known distance "
                "apart, are needed; the placement is not used");
    assert_part(notes, "a.tsv: 1 of 5 rows repeat others of it");
    assert_part(notes, "b.tsv: 5 of 7 rows repeat rows of ");
    assert_ok(load(paths, 1, NULL));
    assert_int_equal(data.n_rows, 4);
    assert_ok(load(paths, 2, &partial)); /* recording goes on with all rows */
    assert_int_equal(data.n_rows, 12);
}

static const mukca_rows_format degrees = {.angle = M_PI / 180, .length = 1e-3, .units = true};

static const char *three_sockets(void)
{
    return scratch_file("three.tsv",
                        "placement\tsocket\tj1\tj2\np\ta\t0\t0\np\tb\t1\t0\np\tc\t0\t1\n"
                        "p\ta\t0\t0\np\tb\t1\t0\np\tc\t0\t1\n");
}

TEST(distances_are_as_told)
{
    mukca_dataset_options options = {.distance = 0.08};
    assert_ok(load_one(three_sockets(), &options));
    assert_int_equal(data.n_distances, 3);
    assert_close(data.distances[2].distance, 0.08, 0);
    for (int k = 0; k < 3; k++) assert_int_equal(data.distances[k].artefact, k);
    assert_close(mukca_distance_sigma(&data.distances[2]), MUKCA_DISTANCE_SIGMA, 0);
    assert_part(notes, "3 sockets");
    options.distances =
        scratch_file("d.tsv", "socket_a\tsocket_b\tdistance_m\nc\ta\t0.1\nb\tc\t0.07\n");
    assert_ok(load_one(three_sockets(), &options));
    assert_int_equal(data.n_distances, 2);
    assert_int_equal(data.distances[0].a, 0);
    assert_int_equal(data.distances[0].b, 2);
    assert_close(data.distances[0].distance, 0.1, 0);
    static const bad_text bad[] = {
        {"a\tb\t0\n", "d.tsv:2: column 'distance_m': 0 is not above 0"},
        {"a\tb\t50\n", "is 50; distances are in m"},
        {"a\ta\t0.1\n", "same socket"},
        {"a\tb\t0.1\nb\ta\t0.1\n", "d.tsv:3: this pair of sockets has a distance already"},
        {"a\tx\t0.1\n", "no pair of sockets of placement 'p'"},
        {"a\tb\tfar\n", "not a finite number"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char text[128];
        snprintf(text, sizeof text, "socket_a\tsocket_b\tdistance_m\n%s", bad[i].text);
        options.distances = scratch_file("d.tsv", text);
        assert_refused(load_one(three_sockets(), &options), bad[i].part);
    }
}

TEST(bad_sessions_get_one_clear_line)
{
    static const bad_text cases[] = {
        {"placement\tsocket\tj1\nx\t0\t0\n", "s.tsv:1: no column for joint 'j2' (columns: "},
        {"placement\tsocket\tj1\tJ_2\n", "rename column 'J_2' with --columns 'J_2=j2'"},
        {"j1\tj2\n0\t0\n", "neither a session nor a pose log"},
        {"placement\tj1\tj2\n0\t0\t0\n", "no column 'socket'"},
        {"l_j1,l_j2,r_j1,r_j2\n0,0,0,0\n", "several prefixes"},
        {"<?xml version=\"1.0\"?>\n", "is XML"},
        {"j1\tj2\tx_m\ty_m\n0\t0\t0\t0\n", "no column 'z_m'; x_m to z_m belong together"},
        {"placement\tsocket\tj1\tj2\np\t\t0\t0\n", "column 'socket': is empty"},
        {"j1\tj2\tx_m\ty_m\tz_m\n0\t0\t300\t0\t10\n", "is 300; positions are in m"},
        {"j1\tj2\tx_m\ty_m\tz_m\n0\t0\t1\t\t0\n", "a position needs x_m, y_m and z_m"},
        {"j1\tj2\tx_m\ty_m\tz_m\tqw\tqx\tqy\tqz\n0\t0\t1\t0\t0\t1\t1\t0\t0\n",
         "quaternion's length is not 1"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_refused(load_one(scratch_file("s.tsv", cases[i].text), NULL), cases[i].part);
    char text[300] = "placement\tsocket\tj1\tj2\n";
    memset(text + strlen(text), 'x', 70);
    strcat(text, "\t0\t0\t0\n");
    assert_refused(load_one(scratch_file("s.tsv", text), NULL), "longer than 63 characters");
}

/* Placement b has one socket, socket 2 of a one row: what is whole is used. */
TEST(unfinished_placements_are_set_aside)
{
    const char *path =
        scratch_file("s.tsv",
                     "placement\tsocket\tj1\tj2\na\t0\t0\t0\na\t0\t1\t0\na\t1\t0\t1\na\t1\t1\t1\n"
                     "a\t2\t2\t1\nb\t0\t0\t2\nb\t0\t1\t2\n");
    assert_ok(load_one(path, NULL));
    assert_int_equal(data.n_rows, 4);
    assert_int_equal(data.n_placements, 1);
    assert_int_equal(data.n_sockets, 2);
    assert_int_equal(data.n_distances, 1);
    assert_part(notes,
                "socket '2': 1 row; at least 2 are needed, 20 or more recommended;"
                " the socket is not used");
    assert_part(notes, "placement 'b': only one socket");
}

TEST(folders_of_placements_are_read)
{
    scratch_file("lab/notes.txt", "table 3\n");
    folder("lab/high", "0,0\n1,1\n", "0,1\n1,0\n");
    folder("lab/back", "0,2\n1,2\n", "0,-1\n1,-2\n");
    folder("lab/half", "2,2\n1,-2\n", NULL);
    assert_ok(load_one(scratch_path("lab"), NULL));
    assert_int_equal(data.n_rows, 8);
    assert_int_equal(data.n_placements, 2);
    assert_string_equal(data.placements[0].name, "back");
    assert_string_equal(data.placements[1].name, "high");
    assert_part(notes, "placement 'half': only one socket");
}

/* One orientation (scipy's, turns of 40, -25 and 110 degrees about z, y, x) in all forms. */
TEST(orientations_are_read)
{
    static const double q[4] = {0.465570306171480, 0.793964931227341, 0.156867611669477,
                                0.358129209087548};
    const table cases[] = {
        {"j1,j2,x_m,y_m,z_m,rx,ry,rz\n0,0,1,2,3,1.949482722728496,0.385169025327849,0."
         "879341993784716\n",
         NULL},
        {"j1,j2,x_m,y_m,z_m,roll,pitch,yaw\n0,0,1,2,3,1.919862177193763,-0.436332312998583,0."
         "698131700797732\n",
         NULL},
        {"j1,j2,X,Y,Z,A,B,C\n0,0,1000,2000,3000,40,-25,110\n", &degrees},
        {"j1,j2,x_m.P,y_m.P,z_m.P,rx.P,ry.P,rz.P\n0,0,1,2,3,1.949482722728496,0.385169025327849,0."
         "879341993784716\n",
         NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        if (load_text(cases[i].text, cases[i].format)) fail_msg("%zu: %s", i, error.text);
        double along = 0;
        for (int c = 0; c < 4; c++) along += q[c] * data.quaternion[c];
        assert_close(fabs(along), 1, 1e-14);
        assert_close(data.position[2], 3, 1e-14);
    }
}

/* All columns of a joint are in its unit; rates are per second. */
TEST(columns_of_a_joint_have_its_unit)
{
    assert_ok(
        load_text("j1,j2,j1.command,j2.command,j1.velocity,j2.velocity,x,y,z\n"
                  "90,45,90,45,18,-9,100,200,300\n",
                  &degrees));
    for (int j = 0; j < 2; j++) {
        assert_close(data.q[j], M_PI / (2 + 2 * j), 1e-15);
        assert_close(data.command[j], M_PI / (2 + 2 * j), 1e-15);
        assert_close(data.velocity[j], j ? -M_PI / 20 : M_PI / 10, 1e-15);
    }
}

/* One posture in the ways that people write it; the pose is that of the first text. */
TEST(tables_of_others_are_read)
{
    const mukca_rows_format order = {.by_order = true}, inverse = {.inverse = true},
                            renamed = {.columns = "Basis [deg]=j1, Arm = j2,X=x_m,Y=y_m,Z=z_m"},
                            named = {.columns = "j1,j2,x_m,y_m,z_m,qw,qx,qy,qz"},
                            few = {.columns = "j1,j2"}, none = {.columns = "j7=j1"},
                            both = {.angle = M_PI / 180, .length = 1e-3, .by_order = true};
#define MATRIX "m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23,m30,m31,m32,m33"
    const table cases[] = {
        {"j1,j2,x_m,y_m,z_m,qw,qx,qy,qz\n0.5,-1,0.1,0.2,0.3,0,0,0,1\n", NULL},
        {"j1;j2;x_mm;y_mm;z_mm;qw;qx;qy;qz\n0,5;-1;100,0;200;300;0;0;0;1\n", NULL},
        {"j1,j2,x,y,z,qw,qx,qy,qz\n28.64788975654116,-57.29577951308232,100,200,300,0,0,0,1\n",
         &degrees},
        {"0.5,-1,0.1,0.2,0.3,0,0,0,1\n", &order},
        {"28.64788975654116,-57.29577951308232,100,200,300,0,0,0,1\n", &both},
        {"j1,j2," MATRIX "\n0.5,-1,-1,0,0,.1,0,-1,0,.2,0,0,1,.3,0,0,0,1\n", NULL},
        {"0.5,-1,-1,0,0,.1,0,-1,0,.2,0,0,1,.3,0,0,0,1\n", &order},
        {"j1,j2," MATRIX "\n0.5,-1,-1,0,0,.1,0,-1,0,.2,0,0,1,-.3,0,0,0,1\n", &inverse},
        {"0.5,-1,-1,0,0,.1,0,-1,0,.2,0,0,1,.3\n", &order},
        {"j1,j2,m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23\n"
         "0.5,-1,-1,0,0,.1,0,-1,0,.2,0,0,1,.3\n",
         NULL},
        {" j1 j2  x_m y_m z_m qw qx qy qz \n0.5 -1 0.1 0.2  0.3 0 0 0 1 \n", NULL},
        {"\xEF\xBB\xBF"
         "Basis [\xC2\xB0];Arm (rad);X [mm];Y [m];Z [cm];qw;qx;qy;qz\n"
         "28,64788975654116;-1;100;0,2;30;0;0;0;1\n",
         &renamed},
        {"0.5,-1,0.1,0.2,0.3,0,0,0,1\n", &named},
        {"q2 (rad),q1 (deg),x [mm],y [mm],z [mm],qw,qx,qy,qz\n"
         "-1,28.64788975654116,100,200,300,0,0,0,1\n",
         NULL},
        {"left_j2,left_j1,x_m,y_m,z_m,qw,qx,qy,qz\n-1,0.5,0.1,0.2,0.3,0,0,0,1\n", NULL},
        {"timestamp actual_q_0 actual_q_1 actual_TCP_pose_0 actual_TCP_pose_1 actual_TCP_pose_2 "
         "actual_TCP_pose_3 actual_TCP_pose_4 actual_TCP_pose_5\n"
         "0 0.5 -1 0.1 0.2 0.3 0 0 3.141592653589793\n",
         NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        if (load_text(cases[i].text, cases[i].format)) fail_msg("%zu: %s", i, error.text);
        assert_int_equal(data.n_rows, 1);
        assert_close(data.q[0], 0.5, 1e-15);
        assert_close(data.q[1], -1, 1e-15);
        for (int c = 0; c < 3; c++) assert_close(data.position[c], 0.1 * (c + 1), 1e-15);
        assert_close(fabs(data.quaternion[3]), 1, 1e-15);
    }
    const struct {
        const char *text;
        const mukca_rows_format *format;
        const char *part;
    } bad[] = {
        {"0.5,-1,0.1,0.2,0.3\n", NULL,
         "t.csv:1: has no header; 5 columns may be 2 joints and x y z: name them in the first "
         "line, or confirm that order with --map order"},
        {"0.5,-1,0.1,0.2\n", &order, "t.csv:1: 4 columns; --map order reads"},
        {"j1,j2,x,y,z\n0,0,1,2,3\n", NULL, "t.csv:1: columns x, y, z without a unit; give --units"},
        {"j1,j2,x_m,y_m,z_m\n400,0,0,0,0\n", &degrees, NULL},
        {"j1,j2,x_m,y_m,z_m\n800,0,0,0,0\n", &degrees,
         "t.csv:2: column 'j1': joint 'j1' is 800 degrees, more than two turns"},
        {"j1,j2,x_m,y_m,z_m\n8,0,1,2,3\n", &inverse, "--inverse-poses needs orientations"},
        {"j1,j2," MATRIX "\n0,0,1,0,0,0,0,1,0,0,0,0,1,0,.1,.2,.3,1\n", NULL,
         "t.csv:2: column 'm30': the last row of the matrix is not 0 0 0 1"},
        {"j1,j2," MATRIX "\n0,0,1,0,0,0,0,2,0,0,0,0,1,0,0,0,0,1\n", NULL, "contains no rotation"},
        {"j1,j2," MATRIX "\n0,0,1,0,0,0,0,1,0,0,0,0,-1,0,0,0,0,1\n", NULL, "left-handed"},
        {"1,2,3\n", &few, "--columns j1,j2 names 2 columns, but the table has 3"},
        {"a,b\n1,2\n", &none, "no column 'j7', which --columns renames"},
        {"j1,j2," MATRIX "\n0,0,1,0,0,0,0,1,0,,0,0,1,0,0,0,0,1\n", NULL,
         "all numbers of its matrix"},
        {"j1,j2,m00\n0,0,1\n", NULL, "no column 'm23'; m00 to m23 belong together"},
        {"j1,j2,x_m,y_m,z_m,rx,ry\n0,0,1,2,3,0,0\n", NULL,
         "no column 'rz'; rx to rz belong together"},
        {"j1,j2,x_m,y_m,z_m,rx,ry,rz\n0,0,1,2,3,90,0,0\n", NULL,
         "column 'rx': is 90; angles are in rad (for degrees: [deg] after the names"},
        {"j1,j2,x_m,y_m,z_m,rx,ry,rz\n0,0,1,2,3,1,,0\n", NULL,
         "an orientation needs all three numbers"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const mukca_status status = load_text(bad[i].text, bad[i].format);
        if (bad[i].part)
            assert_refused(status, bad[i].part);
        else
            assert_ok(status);
    }
}

TEST(doubtful_data_are_read_with_a_note)
{
    const char *path =
        scratch_file("odd.tsv",
                     "# stream: corrected\nplacement\tsocket\tj1\tj2\tcolour\tj9\tj1.spread\n"
                     "p\t0\t3.2\t0\tred\t1\t0\np\t1\t3."
                     "3\t0\tred\t1\t0\np\t0\t0\t0\tred\t1\t0\np\t1\t0\t0\tred\t1\t0\n");
    assert_ok(load_one(path, NULL));
    assert_part(notes, "2 unknown columns ignored: colour, j9\n");
    assert_part(notes, "odd.tsv:3: joint 'j1' is 0.2 rad beyond its limits");
    assert_null(strstr(notes, "odd.tsv:4"));
    assert_part(notes, "corrected these angles already");
    const mukca_dataset_options partial = {.partial = true};
    assert_ok(load_one(scratch_file("s.tsv", "placement\tsocket\tj1\tj2\np\t0\t0\t0\n"), &partial));
    assert_int_equal(data.n_rows, 1);
}

/* x y z and the quaternion of the tip moved by `lever` in its frame. */
static size_t print_pose(char *text, const double q[2], const double lever[3])
{
    mukca_geometry geometry;
    mukca_frame tip;
    double p[3], w[4];
    mukca_geometry_set(&geometry, &chain, NULL);
    mukca_fk_pose(&tip, &geometry, q, NULL);
    mukca_mat3_vec(p, tip.R, lever);
    mukca_rotation_to_quaternion(w, tip.R);
    return (size_t)sprintf(text, "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", p[0] + tip.p[0],
                           p[1] + tip.p[1], p[2] + tip.p[2], w[0], w[1], w[2], w[3]);
}

/* A file of poses beside empty files of angles: the arrays of the rows do not exist yet. */
TEST(poses_without_rows_are_counted)
{
    const char *path = folder("no_rows", "", "");
    scratch_file("no_rows/hole_0_pose.csv", "0,0,0,1,0,0,0\n");
    const mukca_dataset_options partial = {.partial = true};
    assert_ok(load_one(path, &partial));
    assert_int_equal(data.n_rows, 0);
}

/* Poses are measured 30 mm beside the tip; the operator's rows lie close to each other. */
TEST(poses_are_paired_with_their_rows)
{
    enum { N = 12 };
    static const double lever[3] = {0.01, -0.02, 0.02};
    char rows[2000] = "", poses[8000] = "", shorter[8000] = "";
    size_t a = 0, b = 0, c = 0;
    for (int i = 0; i < N; i++) {
        const double q[2] = {0.05 * i, 0.4 * sin(i)};
        a += (size_t)sprintf(rows + a, "%.17g,%.17g\n", q[0], q[1]);
        b += print_pose(poses + b, q, lever);
        if (i != 4) c += print_pose(shorter + c, q, lever);
        const double extra[2] = {0.05 * i + 0.02, 0.4 * cos(i)};
        if (i % 5 == 1) b += print_pose(poses + b, extra, lever);
    }
    const char *path = folder("posed", rows, rows);
    scratch_file("posed/hole_0_pose.csv", poses);
    scratch_file("posed/hole_1_pose.csv", shorter);
    assert_ok(load_one(path, NULL));
    assert_part(notes, "hole_0_pose.csv: 15 poses for 12 rows; 3 dropped");
    assert_part(notes, "hole_1_pose.csv: 11 poses for 12 rows; 1 rows have none");
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, &chain, NULL);
    for (int i = 0; i < 2 * N; i++) {
        mukca_frame tip;
        double p[3], w[4];
        if (i == N + 4) {
            assert_true(isnan(data.position[3 * i]) && isnan(data.quaternion[4 * i]));
            continue;
        }
        mukca_fk_pose(&tip, &geometry, data.q + 2 * i, NULL);
        mukca_mat3_vec(p, tip.R, lever);
        mukca_rotation_to_quaternion(w, tip.R);
        for (int k = 0; k < 3; k++) assert_close(data.position[3 * i + k], p[k] + tip.p[k], 1e-12);
        for (int k = 0; k < 4; k++) assert_close(data.quaternion[4 * i + k], w[k], 1e-12);
    }
    scratch_file("posed/hole_0_pose.csv", "0,0,0,1,0,0\n");
    assert_refused(load_one(path, NULL), "6 columns, but a pose has 7");
    scratch_file("posed/hole_0_pose.csv", "0,0,0,1,1,0,0\n");
    assert_refused(load_one(path, NULL), "length is not 1");
    scratch_file("posed/hole_0_pose.csv", "0,0,300,1,0,0,0\n");
    assert_refused(load_one(path, NULL), "is 300; positions are in m");
}

TEST(subsets_keep_what_belongs_to_their_rows)
{
    const char *path =
        scratch_file("sub.tsv",
                     "placement\tsocket\ttime_s\tj1\tj2\tj1.command\tj2.command\tx_m\ty_m\tz_m\n"
                     "p\t0\t5\t0\t1\t10e-1\t1\t0\t0\t1\np\t1\t6\t.2\t1\t.3\t1\t0\t0\t2\n"
                     "p\t0\t8\t.4\t1\t.5\t1\t0\t0\t3\np\t1\t9\t.6\t2\t\t\t0\t0\t4\n");
    assert_ok(load_one(path, NULL));
    const unsigned char keep[] = {0, 1, 0, 1};
    mukca_dataset part;
    assert_ok(mukca_dataset_subset(&part, &data, keep, &error));
    assert_int_equal(part.n_rows, 2);
    assert_int_equal(part.n_sockets, 2);
    assert_int_equal(part.n_distances, 1);
    assert_int_equal(part.row[1], 4);
    assert_int_equal(part.socket[0], 1);
    assert_true(part.q[2] == 0.6 && part.time[1] == 9 && part.position[5] == 4);
    assert_true(part.command[0] == 0.3 && isnan(part.command[2]));
    assert_null(part.effort);
    assert_string_equal(part.files[0], path);
    mukca_dataset_free(&part);
    mukca_dataset_free(&part);
}

TEST_MAIN(setup, teardown)
