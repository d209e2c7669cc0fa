/* Conventions of orientations: three numbers as scipy reads them, and logs that are in another
 * convention than they say. */
#include "arms.h"
#include "io/dataset.h"
#include "math/angles.h"
#include "mukca/rotation.h"
#include "scratch.h"

enum { JOINTS = 6, ROWS = 24 };
static mukca_chain chain;

/* A six-axis arm of 1.2 m. */
static int setup(void **state)
{
    static const double origin[JOINTS][6] = {
        {0, 0, 0.3},         {0.1, 0, 0.1, -1.5708},  {0.4, 0, 0},
        {0.3, 0, 0, 1.5708}, {0, 0.1, 0.05, -1.5708}, {0, 0, 0.08, 1.5708}};
    make_chain(&chain, "RRRRRR", origin, "j", 3);
    return scratch_setup(state);
}

/* Numbers 0.7, 0.4, 1.9: Rotation.from_euler(c, ...).as_quat(canonical=True), w first, and
 * from_rotvec, of scipy 1.17.1. */
TEST(conventions_are_those_of_scipy)
{
    static const struct {
        const char *convention;
        double q[4];
    } cases[] = {
        {"XYZ", {0.48011272609877, 0.347285279467728, -0.16480225128082, 0.788495353743954}},
        {"xyz", {0.590937787122896, 0.0436786772609306, 0.381914938847565, 0.709243036192877}},
        {"ZYX", {0.590937787122896, 0.709243036192877, 0.381914938847565, 0.0436786772609306}},
        {"zyx", {0.48011272609877, 0.788495353743954, -0.16480225128082, 0.347285279467728}},
        {"XZY", {0.590937787122896, 0.0436786772609306, 0.709243036192877, 0.381914938847565}},
        {"xzy", {0.48011272609877, 0.347285279467728, 0.788495353743954, -0.16480225128082}},
        {"YXZ", {0.590937787122896, 0.381914938847565, 0.0436786772609306, 0.709243036192877}},
        {"yxz", {0.48011272609877, -0.16480225128082, 0.347285279467728, 0.788495353743954}},
        {"YZX", {0.48011272609877, 0.788495353743954, 0.347285279467728, -0.16480225128082}},
        {"yzx", {0.590937787122896, 0.709243036192877, 0.0436786772609306, 0.381914938847565}},
        {"ZXY", {0.48011272609877, -0.16480225128082, 0.788495353743954, 0.347285279467728}},
        {"zxy", {0.590937787122896, 0.381914938847565, 0.709243036192877, 0.0436786772609306}},
        {"XYX", {0.26216666154664, 0.944351173332745, 0.163968874295436, -0.11217714232786}},
        {"xyx", {0.26216666154664, 0.944351173332745, 0.163968874295436, 0.11217714232786}},
        {"XZX", {0.26216666154664, 0.944351173332745, 0.11217714232786, 0.163968874295436}},
        {"xzx", {0.26216666154664, 0.944351173332745, -0.11217714232786, 0.163968874295436}},
        {"YXY", {0.26216666154664, 0.163968874295436, 0.944351173332745, 0.11217714232786}},
        {"yxy", {0.26216666154664, 0.163968874295436, 0.944351173332745, -0.11217714232786}},
        {"YZY", {0.26216666154664, -0.11217714232786, 0.944351173332745, 0.163968874295436}},
        {"yzy", {0.26216666154664, 0.11217714232786, 0.944351173332745, 0.163968874295436}},
        {"ZXZ", {0.26216666154664, 0.163968874295436, -0.11217714232786, 0.944351173332745}},
        {"zxz", {0.26216666154664, 0.163968874295436, 0.11217714232786, 0.944351173332745}},
        {"ZYZ", {0.26216666154664, 0.11217714232786, 0.163968874295436, 0.944351173332745}},
        {"zyz", {0.26216666154664, -0.11217714232786, 0.163968874295436, 0.944351173332745}},
        {"vector", {0.513113199064319, 0.291100499732465, 0.166343142704266, 0.790129927845261}},
    };
    const double numbers[3] = {0.7, 0.4, 1.9};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double R[9], q[4], back[3];
        assert_true(mukca_angles_known(cases[i].convention));
        mukca_angles_to_rotation(R, numbers, cases[i].convention);
        mukca_rotation_to_quaternion(q, R);
        for (int c = 0; c < 4; c++) assert_close(q[c], cases[i].q[c], 1e-14);
        mukca_angles_from_rotation(back, R, cases[i].convention);
        for (int c = 0; c < 3; c++) assert_close(back[c], numbers[c], 1e-14);
    }
    /* gimbal lock: any numbers of the same rotation */
    for (size_t i = 0; i + 1 < sizeof cases / sizeof *cases; i++) {
        const char *c = cases[i].convention;
        const double second = c[0] == c[2] ? 0 : M_PI / 2;
        double R[9], Q[9], back[3];
        mukca_angles_to_rotation(R, (double[]){0.7, second, 0.4}, c);
        mukca_angles_from_rotation(back, R, c);
        mukca_angles_to_rotation(Q, back, c);
        assert_close(mukca_rotation_between(R, Q), 0, 1e-7);
    }
    const char *unknown[] = {"", "XY", "XXY", "XYZX", "XyZ", "WXY", "quaternion"};
    for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++)
        assert_false(mukca_angles_known(unknown[i]));
}

TEST(options_are_read)
{
    mukca_rotation_form form;
    const char *good[] = {"XYZ", "zyx", "vector", "wxyz", "xyzw", "none", "inverse"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        assert_true(mukca_rotation_form_read(&form, good[i]));
        assert_string_equal(form.as, good[i]);
        assert_string_equal(form.converted, "");
    }
    assert_true(mukca_rotation_form_read(&form, "xyz=vector"));
    assert_string_equal(form.as, "vector");
    assert_string_equal(form.converted, "xyz");
    const char *bad[] = {"", "xxz", "=XYZ", "XYZ=", "wxyz=XYZ", "XYZ=wxyz", "XYZXYZXYZ", "vectors"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(mukca_rotation_form_read(&form, bad[i]));
}

/* ---- logs ---- */

/* How a log writes the pose R, p. */
typedef enum { AS_IS, W_LAST, INVERSE, INVERSE_POSE, XYZ, XYZ_AS_XYZ, VECTOR } writing;

/* Turns about the moved x, y, z. */
static void intrinsic_xyz(double a[3], const double R[9])
{
    a[0] = atan2(-R[5], R[8]), a[1] = asin(R[2]), a[2] = atan2(-R[1], R[0]);
}

static void write_pose(FILE *file, const mukca_frame *T, writing w)
{
    double q[4], a[3], p[3], R[9], v[3];
    memcpy(p, T->p, sizeof p);
    mukca_rotation_to_quaternion(q, T->R);
    intrinsic_xyz(a, T->R);
    mukca_rotation_log(v, T->R);
    if (w == INVERSE_POSE) {
        mukca_mat3_tvec(p, T->R, T->p);
        for (int i = 0; i < 3; i++) p[i] *= -1;
    }
    for (int i = 1; i < 4 && (w == INVERSE || w == INVERSE_POSE); i++) q[i] *= -1;
    if (w == XYZ_AS_XYZ) { /* roll, pitch, yaw of a URDF */
        mukca_rotation_from_rpy(R, a);
        mukca_rotation_to_quaternion(q, R);
    }
    fprintf(file, ",%.12f,%.12f,%.12f", p[0], p[1], p[2]);
    if (w == XYZ || w == VECTOR)
        for (int i = 0; i < 3; i++) fprintf(file, ",%.12f", w == XYZ ? a[i] : v[i]);
    else
        for (int i = 0; i < 4; i++) fprintf(file, ",%.12f", q[w == W_LAST ? (i + 1) % 4 : i]);
    fprintf(file, "\n");
}

/* A log of n rows that turn the tool, after `still` that do not, in frames of a tracker. */
static const char *write_log(writing w, const char *turned, int still, int n)
{
    const char *path;
    mukca_geometry geometry;
    mukca_frame tracker = {.p = {2, -1, 0.5}}, target = {.p = {0.03, 0.02, 0.1}};
    mukca_rotation_exp(tracker.R, (double[]){0.4, -0.3, 1.2});
    mukca_rotation_exp(target.R, (double[]){-0.8, 0.5, 0.3});
    FILE *file = scratch_create(&path, "log.csv");
    mukca_geometry_set(&geometry, &chain, NULL);
    fprintf(file, "j1,j2,j3,j4,j5,j6,x_m,y_m,z_m,%s\n", turned);
    for (int i = -still; i < n; i++) {
        double q[JOINTS];
        mukca_frame T;
        for (int j = 0; j < JOINTS; j++) q[j] = i < 0 ? 0.3 : 1.2 * sin(1 + i * (0.7 + 0.31 * j));
        for (int j = 0; j < JOINTS; j++) fprintf(file, j ? ",%.12f" : "%.12f", q[j]);
        mukca_fk_pose(&T, &geometry, q, NULL);
        mukca_frame_multiply(&T, &T, &target);
        mukca_frame_multiply(&T, &tracker, &T);
        write_pose(file, &T, w);
    }
    fclose(file);
    return path;
}

static mukca_status load(const char *path, const char *form, bool inverse)
{
    mukca_dataset data = {0};
    mukca_dataset_options options = {.notes = {note, NULL}, .format.inverse = inverse};
    notes[0] = error.text[0] = '\0';
    if (form) assert_true(mukca_rotation_form_read(&options.format.rotation, form));
    const mukca_status status = mukca_dataset_load(&data, &chain, &path, 1, &options, &error);
    mukca_dataset_free(&data);
    return status;
}

TEST(the_form_that_fits_is_named)
{
    const char *quaternion = "qw,qx,qy,qz", *vector = "rx,ry,rz", *rpy = "roll,pitch,yaw";
    const struct {
        writing writing;
        const char *turned, *form; /* that reads it */
        const char *said;          /* without the form */
    } cases[] = {
        {AS_IS, quaternion, NULL, NULL},
        {VECTOR, vector, NULL, NULL},
        {W_LAST, quaternion, "xyzw", "the quaternions fit as xyzw: --rotation xyzw"},
        {AS_IS, "qx,qy,qz,qw", "wxyz", "the quaternions fit as wxyz: --rotation wxyz"},
        {INVERSE, quaternion, "inverse", "fit as their inverses: --rotation inverse"},
        {INVERSE_POSE, quaternion, NULL,
         "of the fixed frame in the target's: give --inverse-poses"},
        {XYZ, rpy, "XYZ", "column 'roll': "},
        {XYZ, rpy, "XYZ", "the angles fit as intrinsic XYZ: --rotation XYZ"},
        {XYZ, vector, "XYZ", "the angles fit as intrinsic XYZ: --rotation XYZ"},
        {VECTOR, rpy, "vector", "the angles fit as a rotation vector: --rotation vector"},
        {XYZ, "rx [deg],ry [deg],rz [deg]", NULL,
         "fit as intrinsic XYZ in radians: --rotation XYZ, and the unit after the columns' names"},
        {XYZ_AS_XYZ, quaternion, "xyz=XYZ",
         "angles that are intrinsic XYZ were converted as extrinsic xyz: --rotation xyz=XYZ"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *path = write_log(cases[i].writing, cases[i].turned, 0, ROWS);
        if (cases[i].said) {
            assert_refused(load(path, NULL, false),
                           "the orientations contradict the positions by ");
            assert_part(error.text, cases[i].said);
        }
        if (strchr(cases[i].turned, '[')) continue; /* the header is wrong */
        assert_int_equal(load(path, cases[i].form, cases[i].writing == INVERSE_POSE), MUKCA_OK);
        assert_string_equal(notes, "");
    }
}

/* The samples of the check are spread over a long log, whatever comes first. */
TEST(a_long_log_is_checked_to_its_end)
{
    assert_refused(load(write_log(XYZ, "roll,pitch,yaw", 3000, ROWS), NULL, false),
                   "log.csv:3025: column 'roll': ");
    assert_part(error.text, "--rotation XYZ");
}

/* A tool that keeps its orientation says nothing of the convention. */
TEST(few_orientations_decide_nothing)
{
    assert_int_equal(load(write_log(XYZ, "roll,pitch,yaw", 99, 0), NULL, false), MUKCA_OK);
}

TEST(forms_of_other_columns_are_refused)
{
    assert_refused(load(write_log(XYZ, "roll,pitch,yaw", 0, ROWS), "xyzw", false),
                   "column 'roll': --rotation xyzw, but the orientations are three numbers");
    assert_refused(load(write_log(AS_IS, "qw,qx,qy,qz", 0, ROWS), "XYZ", false),
                   "column 'qw': --rotation XYZ, but the orientations are quaternions");
    assert_int_equal(load(write_log(XYZ, "roll,pitch,yaw", 0, ROWS), "none", false), MUKCA_OK);
}

TEST_MAIN(setup, scratch_teardown)
