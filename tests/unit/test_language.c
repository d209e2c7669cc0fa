/* Targets in robot programs: what is printed is found again, and nothing else is. */
#include "io/language.h"

#include <stdlib.h>

#include "close.h"
#include "gen3.h"

enum { RAPID, KRL, URSCRIPT };

static mukca_chain chain;

static char *print(int language, const double *q)
{
    char *text = NULL;
    size_t size;
    FILE *stream = open_memstream(&text, &size);
    assert_non_null(stream);
    mukca_language_print(stream, mukca_languages[language], &chain, q);
    assert_int_equal(fclose(stream), 0);
    return text;
}

static bool find(mukca_program_target *t, int language, bool pose, const char *line)
{
    mukca_program_reader reader = {
        .language = mukca_languages[language], .chain = &chain, .pose = pose};
    mukca_program_line(&reader, line);
    return mukca_program_next(t, &reader) && !t->incomplete;
}

static void printed_targets_are_found(void **state)
{
    (void)state;
    static const double q[7] = {0.1, -1.2, 3.1, 1e-7, -0.5, 2, -3.14159265358979};
    for (int joints = 3; joints <= 7; joints++)
        for (int l = 0; l < 3; l++) {
            gen3_chain(&chain);
            chain.n_joints = joints;
            char *text = print(l, q);
            mukca_program_target t;
            assert_true(find(&t, l, false, text));
            for (int j = 0; j < joints; j++) assert_close(t.q[j], q[j], 1.1e-8);
            free(text);
        }
}

static void print_as_the_languages_have_it(void **state)
{
    (void)state;
    static const double q[6] = {0, M_PI / 2, -M_PI / 4, 0.1, 0.2, 0.3};
    static const char *const wanted[3] = {
        "[[0.000000,90.000000,-45.000000,5.729578,11.459156,17.188734],[9E9,9E9,9E9,9E9,9E9,9E9]]",
        "{A1 0.000000,A2 90.000000,A3 -45.000000,A4 5.729578,A5 11.459156,A6 17.188734}",
        "movej([0.000000000,1.570796327,-0.785398163,0.100000000,0.200000000,0.300000000])"};
    gen3_chain(&chain);
    chain.n_joints = 6;
    for (int l = 0; l < 3; l++) {
        char *text = print(l, q);
        assert_string_equal(text, wanted[l]);
        free(text);
    }
}

/* A linear axis is in millimetres where angles are in degrees. */
static void lengths_are_in_millimetres(void **state)
{
    (void)state;
    static const double q[3] = {0.25, M_PI, 0};
    mukca_program_target t;
    gen3_chain(&chain);
    chain.n_joints = 3;
    chain.element[0].type = MUKCA_PRISMATIC;
    char *text = print(KRL, q);
    assert_string_equal(text, "{A1 250.000000,A2 180.000000,A3 0.000000}");
    assert_true(find(&t, KRL, false, text));
    assert_close(t.q[0], 0.25, 1e-12);
    free(text);
}

static void other_text_is_no_target(void **state)
{
    (void)state;
    static const struct {
        int language;
        const char *line;
    } none[] = {
        {RAPID, "! [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]]"},
        {RAPID, "VAR robtarget p:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"},
        {RAPID, "[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9]]"},
        {RAPID, "[[1,2,3,4,5,6"},
        {RAPID, ""},
        {KRL, "{X 1,Y 2,Z 3,A 4,B 5,C 6}"},
        {KRL, "{A1 1,A2 2,A3 3,A4 4,A5 5,A10 6}"},
        {KRL, "; {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}"},
        {KRL, "{A1 1,A2 2,A3 3,A4 4,A5 5} A6 6}"},
        {URSCRIPT, "force_mode([0,0,1,0,0,0])"},
        {URSCRIPT, "movel(p[1,2,3,0,0,0])"},
        {URSCRIPT, "movej([1,2,3,4,5,nan])"},
        {URSCRIPT, "movej([1,2,3,4,5,6,7])"},
        {URSCRIPT, "# movej([1,2,3,4,5,6])"}};
    mukca_program_target t;
    gen3_chain(&chain);
    chain.n_joints = 6;
    for (size_t i = 0; i < sizeof none / sizeof *none; i++)
        if (find(&t, none[i].language, false, none[i].line)) fail_msg("%s", none[i].line);
    assert_true(find(&t, URSCRIPT, false, "  movej( [1, 2,3 ,4,5, +6.0e0 ], a=1)"));
    assert_close(t.q[5], 6, 0);
    assert_true(find(&t, URSCRIPT, false, "global Waypoint_1_q=[1,2,3,4,5,6]"));
    assert_true(find(&t, KRL, false, "XHOME={E6AXIS: A1 1,A2 2,A3 3,A4 4,A5 5,A6 6,E1 9}"));
}

/* The same pose in the three languages: 90 degrees about z, then 90 about the new x. */
static void poses(void **state)
{
    (void)state;
    static const char *const lines[3] = {
        "MoveL [[100,-200,300],[0.5,0.5,0.5,0.5],[0,-1,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]], v1, z1, t;",
        "LIN {FRAME: X 100, Y -200, Z 300, A 90, B 0, C 90}",
        "movel(p[0.1,-0.2,0.3,1.2091995761561452,1.2091995761561452,1.2091995761561452])"};
    static const double R[9] = {0, 0, 1, 1, 0, 0, 0, 1, 0};
    mukca_program_target t;
    gen3_chain(&chain);
    for (int l = 0; l < 3; l++) {
        assert_true(find(&t, l, true, lines[l]));
        assert_close(t.pose.p[0], 0.1, 1e-15);
        assert_close(t.pose.p[1], -0.2, 1e-15);
        assert_close(t.pose.p[2], 0.3, 1e-15);
        for (int i = 0; i < 9; i++) assert_close(t.pose.R[i], R[i], 1e-12);
    }
    assert_false(
        find(&t, RAPID, true, "[[1,2,3],[0.5,0.5,0.5,0.9],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"));
}

/* Axes that the arm lacks, and blanks, stay. */
static void replacing_keeps_the_rest(void **state)
{
    (void)state;
    static const double q[6] = {0};
    char *text = NULL;
    size_t size;
    mukca_program_target t;
    gen3_chain(&chain);
    chain.n_joints = 6;
    const char *line = "PTP {E6AXIS: A1 1, A2 2,A3 3,A4 4,A5 5,A6 6, E1 1500.5} C_PTP";
    mukca_program_reader reader = {.language = mukca_languages[KRL], .chain = &chain};
    mukca_program_line(&reader, line);
    assert_true(mukca_program_next(&t, &reader));
    FILE *stream = open_memstream(&text, &size);
    assert_non_null(stream);
    mukca_language_replace(stream, &reader, &t, q);
    assert_int_equal(fclose(stream), 0);
    assert_string_equal(text,
                        "{E6AXIS: A1 0.000000, A2 0.000000,A3 0.000000,A4 0.000000,"
                        "A5 0.000000,A6 0.000000, E1 1500.5}");
    free(text);
}

/* A pose is written where it stood, in the numbers of the language; all else stays. */
static void poses_are_replaced(void **state)
{
    (void)state;
    static const struct {
        int language;
        const char *line, *wanted;
    } cases[] = {
        {RAPID, "MoveL [[1,2,3],[-0.5,-0.5,-0.5,-0.5],[0,-1,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]], v1;",
         "[[400.000000,-100.000000,500.000000],[-0.500000000,-0.500000000,-0.500000000,-0."
         "500000000],"
         "[0,-1,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]]"},
        {KRL, "LIN {FRAME: C 80, X 1,Y 2,Z 3,A 80,B 0,S 2,T 10} C_DIS",
         "{FRAME: C 90.000000, X 400.000000,Y -100.000000,Z 500.000000,A 90.000000,B 0.000000,"
         "S 2,T 10}"},
        {URSCRIPT, "movel(p[0.1,-0.2,0.3,1.2,1.2,1.2], a=1)",
         "p[0.400000000,-0.100000000,0.500000000,1.209199576,1.209199576,1.209199576]"}};
    static const mukca_frame pose = {.R = {0, 0, 1, 1, 0, 0, 0, 1, 0}, .p = {0.4, -0.1, 0.5}};
    gen3_chain(&chain);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        mukca_program_reader reader = {
            .language = mukca_languages[cases[i].language], .chain = &chain, .pose = true};
        mukca_program_target t;
        char *text = NULL;
        size_t size;
        mukca_program_line(&reader, cases[i].line);
        assert_true(mukca_program_next(&t, &reader));
        FILE *stream = open_memstream(&text, &size);
        assert_non_null(stream);
        mukca_language_replace_pose(stream, &reader, &t, &pose);
        assert_int_equal(fclose(stream), 0);
        assert_string_equal(text, cases[i].wanted);
        free(text);
    }
}

/* KRL: what a move leaves out is that of the move before, where that is in the program. */
static void components_are_carried_over(void **state)
{
    (void)state;
    static const struct {
        const char *line;
        int targets;    /* that are found */
        double x, y, a; /* of a complete one; NaN: incomplete */
    } lines[] = {{"LIN {X 100}", 1, NAN, 0, 0},
                 {"PTP {X 1,Y 2,Z 3,A 10,B 20,C 30,S 2,T 10}", 1, 1, 2, 10},
                 {"lin {x 100, a 40}", 1, 100, 2, 40},
                 {"LIN {Y 7}", 1, 100, 7, 40},
                 {"XP2={X 5,Y 6,Z 3,A 10,B 20,C 30}", 1, 5, 6, 10},
                 {"WAIT SEC 1", 0, 0, 0, 0},
                 {"LIN {Y 8}", 1, 100, 8, 40},
                 {"LIN_REL {X 0,Y 0,Z 3,A 0,B 0,C 0}", 0, 0, 0, 0},
                 {"LIN {Y 8}", 1, NAN, 0, 0},
                 {"PTP {X 1,Y 2,Z 3,A 10,B 20,C 30}", 1, 1, 2, 10},
                 {"LIN XP7 C_DIS", 0, 0, 0, 0},
                 {"LIN {Y 8}", 1, NAN, 0, 0},
                 {"$BASE={X 1,Y 2,Z 3,A 10,B 20,C 30}", 0, 0, 0, 0},
                 {"TOOL_DATA[1]={X 1,Y 2,Z 3,A 10,B 20,C 30}", 0, 0, 0, 0},
                 {"LIN XP1:{X 1,Y 2,Z 3,A 10,B 20,C 30}", 0, 0, 0, 0},
                 {"LIN {X 1,Y 2,Z 3,A 10,B 20,C 30} : XP1", 0, 0, 0, 0}};
    gen3_chain(&chain);
    mukca_program_reader reader = {.language = mukca_languages[KRL], .chain = &chain, .pose = true};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        mukca_program_target t;
        int found = 0;
        mukca_program_line(&reader, lines[i].line);
        for (; mukca_program_next(&t, &reader); found++) {
            if (t.incomplete != isnan(lines[i].x)) fail_msg("%zu: %s", i, lines[i].line);
            if (t.incomplete) continue;
            assert_close(t.pose.p[0], 1e-3 * lines[i].x, 1e-12);
            assert_close(t.pose.p[1], 1e-3 * lines[i].y, 1e-12);
            assert_close(atan2(t.pose.R[3], t.pose.R[0]), lines[i].a * M_PI / 180, 1e-12);
        }
        if (found != lines[i].targets) fail_msg("%zu: %s", i, lines[i].line);
    }
}

/* Written out again, with the components that were carried over. */
static void partial_targets_are_completed(void **state)
{
    (void)state;
    static const double q[6] = {0.1, 0.2, 0.3, 0.4, 0.5, M_PI};
    mukca_program_target t;
    char *text = NULL;
    size_t size;
    gen3_chain(&chain);
    chain.n_joints = 6;
    mukca_program_reader reader = {.language = mukca_languages[KRL], .chain = &chain};
    mukca_program_line(&reader, "PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}");
    assert_true(mukca_program_next(&t, &reader));
    mukca_program_line(&reader, "PTP {A6 180,E1 5}");
    assert_true(mukca_program_next(&t, &reader));
    assert_false(t.incomplete);
    assert_close(t.q[4], 5 * M_PI / 180, 1e-12);
    FILE *stream = open_memstream(&text, &size);
    assert_non_null(stream);
    mukca_language_replace(stream, &reader, &t, q);
    assert_int_equal(fclose(stream), 0);
    assert_string_equal(text,
                        "{A6 180.000000,E1 5,A1 5.729578,A2 11.459156,A3 17.188734,A4 "
                        "22.918312,A5 28.647890}");
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(printed_targets_are_found),
                                       cmocka_unit_test(print_as_the_languages_have_it),
                                       cmocka_unit_test(lengths_are_in_millimetres),
                                       cmocka_unit_test(other_text_is_no_target),
                                       cmocka_unit_test(poses),
                                       cmocka_unit_test(poses_are_replaced),
                                       cmocka_unit_test(components_are_carried_over),
                                       cmocka_unit_test(partial_targets_are_completed),
                                       cmocka_unit_test(replacing_keeps_the_rest)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
