/* URDF: chains, masses of side branches, gravity, and a clear line for every trap. */
#include "io/urdf.h"

#include "scratch.h"

static mukca_chain chain;

static mukca_status load(const char *text, const mukca_urdf_options *options)
{
    notes[0] = '\0';
    error.text[0] = '\0';
    mukca_urdf_options noted = options ? *options : (mukca_urdf_options){.base = NULL};
    noted.notes.write = note;
    return mukca_urdf_load(&chain, scratch_file("r.urdf", text), &noted, &error);
}

#define LIMIT "<limit lower='-1' upper='2' effort='1' velocity='1'/>"
#define JOINT(name, type, parent, child, inside)                                            \
    "<joint name='" name "' type='" type "'><parent link='" parent "'/><child link='" child \
    "'/>" inside "</joint>"
#define MASS(kg, xyz)                                   \
    "<inertial><origin xyz='" xyz "'/><mass value='" kg \
    "'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"

/* base -a-> l1 -f-> l2 (prismatic p) -> l3 -tool-> ball; a gripper hangs on l2. */
static const char arm[] =
    "<?xml version='1.0'?>\n<robot name='arm'>\n"
    "<link name='base'>" MASS("9", "0 0 0") "</link><link name='l1'>" MASS("2", "0.1 0 0") "</link>"
    "<link name='l2'>" MASS("1", "0 0 0") "</link><link name='l3'/><link name='ball'/>"
    "<link name='grip'>" MASS("0.5", "0 0 0.2") "</link><link name='finger'>" MASS("0.5", "0 1 0") "</link>\n"
    JOINT("a", "revolute", "base", "l1",
          "<origin xyz='0 0 0.3' rpy='0.1 1.5707963267948966 -0.2'/><axis xyz='0 0 3'/>" LIMIT)
    JOINT("f", "fixed", "l1", "l2", "<origin xyz='1e-3 0\t-2'/>")
    JOINT("p", "prismatic", "l2", "l3", "<axis xyz='0 -1 0'/>" LIMIT)
    JOINT("c", "continuous", "l3", "ball", "<origin rpy='0 0 1'/>")
    JOINT("g", "fixed", "l2", "grip", "<origin xyz='0 0 1' rpy='0 0 1.5707963267948966'/>")
    JOINT("m", "prismatic", "grip", "finger", "<mimic joint='p'/><origin xyz='0.25 0 0'/>" LIMIT)
    "</robot>\n";

TEST(a_chain_is_read_exactly)
{
    assert_ok(load(arm, NULL));
    assert_string_equal(chain.robot, "arm");
    assert_string_equal(chain.base, "base");
    assert_string_equal(chain.tip, "ball");
    assert_int_equal(chain.n_elements, 4);
    assert_int_equal(chain.n_joints, 3);
    static const mukca_joint_type types[] = {MUKCA_REVOLUTE, MUKCA_FIXED, MUKCA_PRISMATIC,
                                             MUKCA_CONTINUOUS};
    static const int joint[] = {0, -1, 1, 2};
    for (int k = 0; k < 4; k++) {
        assert_int_equal(chain.element[k].type, types[k]);
        assert_int_equal(chain.element[k].joint, joint[k]);
    }
    /* what is written, to the last bit, at gimbal lock too */
    assert_true(chain.element[0].rpy[0] == 0.1);
    assert_true(chain.element[0].rpy[1] == 1.5707963267948966);
    assert_true(chain.element[0].rpy[2] == -0.2);
    assert_true(chain.element[1].xyz[0] == 1e-3 && chain.element[1].xyz[2] == -2);
    assert_true(chain.element[0].axis[2] == 1);
    assert_part(notes, "joint 'a': its axis has length 3");
    assert_true(chain.element[2].axis[1] == -1);
    assert_true(chain.element[3].axis[0] == 1); /* URDF's default */
    assert_true(chain.element[0].lower == -1 && chain.element[0].upper == 2);
    assert_true(chain.element[3].upper == HUGE_VAL);
    assert_int_equal(mukca_chain_find_joint(&chain, "c"), 2);
}

TEST(side_branches_are_folded_onto_the_chain)
{
    assert_ok(load(arm, NULL));
    assert_int_equal(chain.n_masses, 2); /* the base's own does not move */
    assert_int_equal(chain.mass[0].element, 0);
    assert_close(chain.mass[0].kg, 2, 0);
    assert_close(chain.mass[0].com[0], 0.1, 1e-15);
    /* l2: 1 kg at 0; grip: 0.5 kg at (0, 0, 1.2); finger, turned by 90 degrees about z:
     * 0.5 kg at (0, 0.25, 1) + Rz(90) (0, 1, 0) = (-1, 0.25, 1) */
    assert_int_equal(chain.mass[1].element, 1);
    assert_close(chain.mass[1].kg, 2, 1e-15);
    assert_close(chain.mass[1].com[0], -0.5 / 2, 1e-15);
    assert_close(chain.mass[1].com[1], 0.125 / 2, 1e-15);
    assert_close(chain.mass[1].com[2], 1.1 / 2, 1e-15);
    const mukca_urdf_options options = {
        .inertials = scratch_file("i.tsv",
                                  "link\tmass_kg\tcom_x_m\tcom_y_m\tcom_z_m\n"
                                  "l1\t7\t0\t0\t1\nball\t0.25\t0\t0\t0\n")};
    assert_ok(load(arm, &options));
    assert_int_equal(chain.n_masses, 3);
    assert_close(chain.mass[0].kg, 7, 0);
    assert_close(chain.mass[0].com[2], 1, 0);
    assert_close(chain.mass[2].kg, 0.25, 0);
    assert_int_equal(chain.mass[2].element, 3);
}

/* Names in side branches may be longer than those of the chain. */
TEST(a_long_name_has_its_origin)
{
#define LONG_JOINT \
    "a_joint_whose_name_is_longer_than_the_sixty_three_characters_that_the_chain_holds"
    assert_ok(
        load("<robot name='x'><link name='a'/><link name='b'/><link name='ball'/><link name='side'>"
             "<inertial><mass value='1'/></inertial></link>"
             "<joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint>"
             "<joint name='k' type='fixed'><parent link='b'/><child link='ball'/></joint>"
             "<joint name='" LONG_JOINT "' type='fixed'><origin xyz='0 0 2'/>"
             "<parent link='b'/><child link='side'/></joint></robot>",
             NULL));
    assert_close(chain.mass[0].com[2], 2, 0);
}

/* R I R' for a pitch of 3 mrad less than 90 degrees. */
TEST(tensors_are_turned_exactly)
{
    const double pitch = 1.5677963267948966, c = cos(pitch), s = sin(pitch);
    assert_ok(
        load("<robot name='x'><link name='a'/><link name='b'><inertial>"
             "<origin rpy='0 1.5677963267948966 0'/><mass value='1'/>"
             "<inertia ixx='1' iyy='2' izz='3' ixy='0' ixz='0' iyz='0'/></inertial></link>"
             "<joint name='j' type='continuous'><parent link='a'/><child link='b'/>"
             "</joint></robot>",
             NULL));
    const double wanted[6] = {c * c + 3 * s * s, 2, s * s + 3 * c * c, 0, 2 * s * c, 0};
    for (int i = 0; i < 6; i++) assert_close(chain.mass[0].inertia[i], wanted[i], 1e-14);
}

TEST(any_two_links_make_a_chain)
{
    mukca_urdf_options options = {.base = "l1", .tip = "l3"};
    assert_ok(load(arm, &options));
    assert_int_equal(chain.n_elements, 2);
    assert_int_equal(chain.n_joints, 1);
    /* gravity of an upright root, in l1's frame: z of the base is -x of l1 at pitch 90, yaw and
     * roll cancel to a turn about it */
    assert_close(mukca_dot3(chain.gravity, chain.gravity), 9.80665 * 9.80665, 1e-12);
    assert_close(chain.gravity[0], 9.80665, 1e-12);
    assert_part(notes, "--gravity");
    options.gravity[1] = 1;
    assert_ok(load(arm, &options));
    assert_true(chain.gravity[0] == 0 && chain.gravity[1] == 1);
    options.base = NULL;
    options.tip = "grip";
    assert_ok(load(arm, &options));
    assert_string_equal(chain.tip, "grip");
}

#define TWO(inside) \
    "<robot name='r'>\n<link name='a'/><link name='b'/><link name='c'/>\n" inside "</robot>"
#define LONG "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx"
#define AB JOINT("j", "revolute", "a", "b", LIMIT)
#define BC JOINT("k", "fixed", "b", "c", "")

TEST(traps_get_one_clear_line)
{
    static const bad_text cases[] = {
        {"", "is empty"},
        {"<html/>", "not <robot>"},
        {"<robot name='r'/>", "urdfdom cannot read it"},
        {TWO(JOINT("j", "revolute", "a", "b", "<origin xyz='0 0'/>" LIMIT) BC),
         "r.urdf:3: joint 'j': origin xyz and rpy must be three numbers"},
        {TWO(JOINT("j", "revolute", "a", "b", "<origin rpy='0 nan 0'/>" LIMIT) BC), "joint 'j'"},
        {TWO(JOINT("j", "hinge", "a", "b", "") BC), "no known type [hinge]"},
        {TWO(JOINT("j", "revolute", "a", "b", "") BC), "urdfdom cannot read it"}, /* no limit */
        {TWO(AB), "Two root links found"},
        {TWO(AB BC JOINT("l", "fixed", "a", "c", "")), "is the child of two joints"},
        {TWO(AB JOINT("k", "fixed", "b", "z", "")), "child link [z] of joint [k] not found"},
        {TWO(AB JOINT("j", "fixed", "b", "c", "")), "joint 'j' is not unique"},
        {TWO(JOINT("j", "fixed", "a", "b", "") BC), "no joint moves between 'a' and 'c'"},
        {TWO(AB BC "<link name='" LONG "'/>" JOINT("l", "fixed", "c", LONG, "")),
         "is longer than 63 characters"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_refused(load(cases[i].text, NULL), cases[i].part);
}

TEST(bad_masses_get_one_clear_line)
{
    static const bad_text inertials[] = {
        {"l9\t1\t0\t0\t0\n", "did you mean l"},
        {"l1\t-1\t0\t0\t0\n", "i.tsv:2: column 'mass_kg': a mass cannot be negative"},
        {"l1\t1\t0\t0\t0\nl1\t1\t0\t0\t0\n", "i.tsv:3: column 'link': link 'l1' has a row already"},
        {"l1\t1\t0\t0\n", "i.tsv:2: 4 columns"}};
    for (size_t i = 0; i < sizeof inertials / sizeof *inertials; i++) {
        char text[200];
        snprintf(text, sizeof text, "link\tmass_kg\tcom_x_m\tcom_y_m\tcom_z_m\n%s",
                 inertials[i].text);
        const mukca_urdf_options with = {.inertials = scratch_file("i.tsv", text)};
        assert_refused(load(arm, &with), inertials[i].part);
    }
    const mukca_urdf_options lacking = {.inertials = scratch_file("i.tsv", "link\tkg\n")};
    assert_refused(load(arm, &lacking), "no column 'mass_kg'");
}

TEST(zero_bytes_are_refused)
{
    assert_refused(mukca_urdf_load(&chain, scratch_bytes("r.urdf", "<robot\0>", 8), NULL, &error),
                   "zero byte");
}

/* urdfdom's parser finds elements in what XML says is none: it must see elements only. */
TEST(urdfdom_sees_elements_only)
{
    enum { DEPTH = 50000 };
    char *text = malloc(DEPTH * 3 + sizeof arm + 400);
    const char *rest = strstr(arm, "<robot");
    size_t n = (size_t)sprintf(text, "<?pi >");
    for (int i = 0; i < DEPTH; i++) n += (size_t)sprintf(text + n, "<x>");
    sprintf(text + n, "?>%s<?pi > <robot><link name='base'/></robot> ?>", rest);
    assert_ok(load(text, NULL));
    assert_int_equal(chain.n_joints, 3);
    sprintf(text, "<!DOCTYPE robot [<!ENTITY a \"> <x>\">]>\n%s", rest);
    assert_refused(load(text, NULL), "r.urdf:1: has a document type");
    sprintf(text, "<!DOCTYPE robot SYSTEM 'http://localhost/x.dtd'>\n%s", rest);
    assert_refused(load(text, NULL), "document type");
    snprintf(
        text, 400,
        "<robot name='a&amp;&#38;&lt;&gt;&quot;&apos;&#233;&#x20AC;'><link name='b'/>"
        "<link name='c'/><![CDATA[<link name='b'/>]]> text <!-- <link name='b'/> -->%s</robot>",
        JOINT("a", "fixed", "b", "d", "")
            JOINT("j", "continuous", "d", "c", "<x:y z:q='1'/>") "<link name='d'/>");
    assert_ok(load(text, NULL));
    assert_string_equal(chain.robot, "a&&<>\"'\u00e9\u20ac");
    free(text);
}

TEST_MAIN(scratch_setup, scratch_teardown)
