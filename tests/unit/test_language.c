/* Targets in robot programs: they are found, and nothing else is. */
#include "io/language.h"

#include "close.h"
#include "gen3.h"

enum { RAPID, KRL, URSCRIPT };

static mukca_chain chain;

/* A linear axis is in millimetres where angles are in degrees. */
TEST(lengths_are_in_millimetres)
{
    static const char line[] = "{A1 250,A2 180,A3 0}";
    static const double q[3] = {0.5, M_PI / 2, 0};
    char *text = NULL;
    size_t size;
    mukca_program_target t;
    gen3_chain(&chain);
    chain.n_joints = 3;
    chain.element[0].type = MUKCA_PRISMATIC;
    assert_int_equal(mukca_language_read(&t, mukca_languages[KRL], &chain, line),
                     MUKCA_LINE_TARGET);
    assert_close(t.q[0], 0.25, 1e-12);
    FILE *stream = open_memstream(&text, &size);
    assert_non_null(stream);
    mukca_language_replace(stream, mukca_languages[KRL], &chain, line, &t, q);
    assert_int_equal(fclose(stream), 0);
    assert_string_equal(text, "{A1 500.000000,A2 90.000000,A3 0.000000}");
    free(text);
}

/* What could move the arm elsewhere is unknown; the rest moves it to a target in numbers, or not.
 */
TEST(lines_are_understood_or_unknown)
{
    static const struct {
        int language;
        mukca_program_line kind;
        const char *line;
    } lines[] = {
        {RAPID, MUKCA_LINE_OTHER, "! [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]]"},
        {RAPID, MUKCA_LINE_UNKNOWN, "CONST robtarget p:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9]];"},
        {RAPID, MUKCA_LINE_UNKNOWN, "[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9]]"},
        {RAPID, MUKCA_LINE_UNKNOWN, "[[1,2,3,4,5,6"},
        {RAPID, MUKCA_LINE_OTHER, " \r"},
        {RAPID, MUKCA_LINE_TARGET,
         "  moveabsj [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E+09]]\\NoEOffs, v1, fine, t; ! home\r"},
        {RAPID, MUKCA_LINE_UNKNOWN,
         "MoveAbsJ [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]], v1, z1, t; MoveL p, v1, z1, t;"},
        {RAPID, MUKCA_LINE_UNKNOWN, "MoveAbsJ home, v1, z1, t;"},
        {RAPID, MUKCA_LINE_UNKNOWN, "Routine;"},
        {RAPID, MUKCA_LINE_UNKNOWN,
         "CONST jointtarget home:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"},
        {RAPID, MUKCA_LINE_UNKNOWN, "MoveL Offs(pick,0,0,50),v100,fine,ball\\WObj:=fixture;"},
        {RAPID, MUKCA_LINE_UNKNOWN,
         "MoveL [[350,0,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;"},
        {RAPID, MUKCA_LINE_OTHER, "PROC main()"},
        {KRL, MUKCA_LINE_UNKNOWN, "{X 1,Y 2,Z 3,A 4,B 5,C 6}"},
        {KRL, MUKCA_LINE_UNKNOWN, "{A1 1,A2 2,A3 3,A4 4,A5 5,A10 6}"},
        {KRL, MUKCA_LINE_UNKNOWN, "PTP {A1 1,A2 2}"},
        {KRL, MUKCA_LINE_UNKNOWN, "{A1 1,A2 2,A3 3,A4 4,A5 5} A6 6}"},
        {KRL, MUKCA_LINE_UNKNOWN, "PTP_REL {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}"},
        {KRL, MUKCA_LINE_TARGET, "ptp {E6AXIS: A1 1,A2 2,A3 3,A4 4,A5 5,A6 6,E1 9} C_PTP ;x"},
        {KRL, MUKCA_LINE_UNKNOWN, "LIN {X 350,Y 0,Z 300,A 0,B 150,C 0} C_DIS"},
        {KRL, MUKCA_LINE_UNKNOWN, "PTP HOME"},
        {KRL, MUKCA_LINE_UNKNOWN, "LIN_REL {Z 50}"},
        {KRL, MUKCA_LINE_UNKNOWN, "XHOME={AXIS: A1 5,A2 -10,A3 20,A4 0,A5 30,A6 0}"},
        {KRL, MUKCA_LINE_OTHER, "END"},
        {KRL, MUKCA_LINE_OTHER, "BAS (#INITMOV,0)"},
        {URSCRIPT, MUKCA_LINE_UNKNOWN, "force_mode([0,0,1,0,0,0])"},
        {URSCRIPT, MUKCA_LINE_UNKNOWN, "movel(p[1,2,3,0,0,0])"},
        {URSCRIPT, MUKCA_LINE_UNKNOWN, "movej([1,2,3,4,5,nan])"},
        {URSCRIPT, MUKCA_LINE_UNKNOWN, "movej([1,2,3,4,5,6,7])"},
        {URSCRIPT, MUKCA_LINE_UNKNOWN, "movej([1,2,3,4,5,6]) movel(pick)"},
        {URSCRIPT, MUKCA_LINE_UNKNOWN, "home = [0, -1.57, 1.57, -1.57, -1.57, 0]"},
        {URSCRIPT, MUKCA_LINE_UNKNOWN, "movej([d2r(10),d2r(-80),d2r(95),d2r(-105),d2r(-90),0])"},
        {URSCRIPT, MUKCA_LINE_UNKNOWN, "movel(pose_add(pick,p[0,0,0.1,0,0,0]))"},
        {URSCRIPT, MUKCA_LINE_OTHER, "end"},
        {URSCRIPT, MUKCA_LINE_OTHER, "# movej([1,2,3,4,5,6])"},
        {URSCRIPT, MUKCA_LINE_OTHER, "def main():"},
        {URSCRIPT, MUKCA_LINE_TARGET, "  movej( [1, 2,3 ,4,5, +6.0e0 ], a=1)"}};
    mukca_program_target t;
    gen3_chain(&chain);
    chain.n_joints = 6;
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++)
        if (mukca_language_read(&t, mukca_languages[lines[i].language], &chain, lines[i].line) !=
            lines[i].kind)
            fail_msg("%s", lines[i].line);
    assert_close(t.q[5], 6, 0);
}

TEST_MAIN(NULL, NULL)
