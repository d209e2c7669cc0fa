/* Exported models hold every calibrated number and leave the rest as it was; notes name what a
 * format lacks. */
#include "io/export.h"

#include "arms.h"
#include "base/number.h"
#include "odd_urdf.h"

static mukca_offsets offsets;

/* A calibrated arm. */
static int setup(void **state)
{
    mukca_random random = mukca_random_seeded(3);
    if (scratch_setup(state) || mukca_urdf_load(&chain, urdf_path(), NULL, &error)) return 1;
    mukca_offsets_init(&offsets, &chain);
    for (int i = 0; i < 18; i++) offsets.theta[i] += 1e-3 * mukca_random_normal(&random);
    return 0;
}

/* A compliance, and one effect that no spring represents. */
static void add_effects(void)
{
    offsets.n_effects = 2;
    offsets.effects[0] = make_effect(MUKCA_EFFECT_JOINT_COMPLIANCE, 1, 1e-4);
    offsets.effects[1] = make_effect(MUKCA_EFFECT_JOINT_SCALE, 0, 1e-3 / 3);
}

/* Export to a file; its content, to be freed. */
static char *export(const char *name, mukca_status wanted)
{
    const char *path;
    const mukca_exporter *exporter = mukca_exporters;
    while (strcmp(exporter->name, name) != 0) exporter++;
    FILE *file = scratch_create(&path, "export");
    const mukca_export_input input = {.urdf_path = urdf_path(),
                                      .chain = &chain,
                                      .offsets = &offsets,
                                      .notes = {note, NULL},
                                      .error = &error};
    notes[0] = '\0';
    assert_int_equal(mukca_export_write(file, exporter, &input), wanted);
    fclose(file);
    return scratch_read(path);
}

/* Text without the origins of joints a, b and t. */
static void drop_origins(char *text)
{
    for (char *at = text; (at = strstr(at, "<origin"));) {
        if (strncmp(at, "<origin xyz='9", 14) == 0 || strncmp(at, "<origin xyz='7", 14) == 0 ||
            strncmp(at, "<origin xyz='0 0 1'", 19) == 0) {
            at++;
            continue;
        }
        char *end = strchr(at, '>') + 1;
        memmove(at, end, strlen(end) + 1);
    }
}

TEST(urdf_keeps_every_other_byte)
{
    char *text = export("urdf", MUKCA_OK);
    const char *path = scratch_file("patched.urdf", text);
    mukca_chain patched;
    assert_ok(mukca_urdf_load(&patched, path, NULL, &error));
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) {
            assert_true(patched.element[k].xyz[i] == offsets.theta[6 * k + i]);
            assert_true(patched.element[k].rpy[i] == offsets.theta[6 * k + 3 + i]);
        }
    /* the joint without an origin got one, on a line of its own */
    assert_part(text, "<joint name='b' type='continuous'>\r\n    <origin xyz=\"");
    assert_part(text, "\r\n    <parent link='l1'/>");
    char whole[sizeof urdf];
    memcpy(whole, urdf, sizeof urdf);
    drop_origins(whole);
    drop_origins(text);
    char *added = strstr(text, "'continuous'>\r\n    \r\n");
    assert_non_null(added);
    memmove(added + 13, added + 13 + 6, strlen(added + 13 + 6) + 1);
    assert_string_equal(text, whole);
    free(text);
}

/* The other numbers of an origin, and origins that did not change, keep their text. */
TEST(urdf_keeps_the_text_of_unchanged_numbers)
{
    static const char number[] = "<origin rpy='0 1.5 0'\txyz = '0.1 -0.2 0.3' >";
    mukca_offsets_init(&offsets, &chain);
    for (int i = 0; i < 18; i++) offsets.theta[i] += 9e-10; /* counts as no offset */
    char *text = export("urdf", MUKCA_OK);
    assert_string_equal(text, urdf);
    free(text);
    offsets.theta[1] = -0.1;
    offsets.theta[12] = 1.0 / 3;
    text = export("urdf", MUKCA_OK);
    assert_null(strstr(text, number));
    assert_part(text, "<origin rpy='0 1.5 0'\txyz = '0.1 -0.1 0.3' >");
    assert_part(text, "<origin xyz=\"0.3333333333333333 0 0.5\" />");
    free(text);
    offsets.theta[16] = 0.25; /* an attribute that is absent */
    text = export("urdf", MUKCA_OK);
    assert_part(text, "<origin xyz=\"0.3333333333333333 0 0.5\" rpy=\"0 0.25 0\" />");
    free(text);
}

TEST(urdf_that_changed_meanwhile_is_refused)
{
    chain.urdf_sha256[0] = 'x';
    free(export("urdf", MUKCA_INPUT));
    assert_part(error.text, "changed during the export");
}

TEST(yaml_and_c_hold_every_number)
{
    add_effects();
    char *yaml = export("yaml", MUKCA_OK), *c = export("c", MUKCA_OK);
    assert_string_equal(notes, "");
    for (int i = 0; i < 18; i++) {
        char number[MUKCA_NUMBER_SIZE];
        mukca_number_format(number, offsets.theta[i]);
        assert_part(yaml, number);
        assert_part(c, number);
    }
    for (int e = 0; e < offsets.n_effects; e++) {
        char number[MUKCA_NUMBER_SIZE];
        mukca_number_format(number, offsets.effects[e].coefficient[0]);
        assert_part(yaml, mukca_effect_table[offsets.effects[e].kind]->name);
        assert_part(yaml, number);
        assert_part(c, number);
    }
    assert_part(yaml, "robot: \"odd & arm\"\n");
    assert_part(c, "enum { odd___arm_elements = 3, odd___arm_joints = 2 };");
    free(yaml);
    free(c);
}

TEST(effects_of_time_are_not_applied)
{
    offsets.n_effects = 1;
    offsets.effects[0] = make_effect(MUKCA_EFFECT_JOINT_DRIFT, 0, 3e-3);
    free(export("urdf", MUKCA_OK));
    assert_part(notes, "joint_drift@0s of a, 3 mrad, depends on time");
    assert_null(strstr(notes, "differs by"));
}

/* An effect that the format lacks moves into the origins as far as they can take it: the zero of an
 * angle that is scaled about another one. */
TEST(origins_take_up_what_a_format_lacks)
{
    offsets.n_effects = 1;
    offsets.effects[0] = make_effect(MUKCA_EFFECT_JOINT_SCALE, 0, 1e-3);
    chain.element[0].lower = 2; /* mean of q 2.5: a zero of 2.5 mrad is most of the effect */
    char *text = export("urdf", MUKCA_OK);
    assert_part(notes, "joint_scale of a is not exported: the format urdf");
    assert_part(notes, "urdf: the origins were fitted to the arm over its joint ranges");
    assert_part(notes, "recommended: the table itself");
    mukca_chain patched;
    mukca_geometry whole, fitted;
    assert_ok(mukca_urdf_load(&patched, scratch_file("patched.urdf", text), NULL, &error));
    mukca_geometry_set(&whole, &chain, offsets.theta);
    mukca_geometry_set(&fitted, &patched, NULL);
    double worst = 0, worst_left_out = 0;
    for (double a = 2.05; a < 3; a += 0.1)
        for (double b = -3; b < 3; b += 0.5) {
            const double q[2] = {a, b}, scaled[2] = {a + 1e-3 * a, b};
            double p[3], r[3], s[3];
            mukca_fk_position(p, &whole, scaled, NULL);
            mukca_fk_position(r, &fitted, q, NULL);
            mukca_fk_position(s, &whole, q, NULL);
            worst = fmax(worst, mukca_distance3(p, r));
            worst_left_out = fmax(worst_left_out, mukca_distance3(p, s));
        }
    assert_true(worst < worst_left_out / 3); /* 0.5 of 3 mrad are left at the ends */
    free(text);
}

/* NumPy's header, then 8 bytes a joint: the angles by which the joints were turned. */
TEST(npy_holds_the_zeros_of_the_joints)
{
    static const double turned[2] = {0.0125, -0.02};
    static const char header[] =
        "\x93NUMPY\x01\0v\0{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }";
    mukca_offsets_init(&offsets, &chain);
    for (int j = 0; j < 2; j++) {
        const int k = chain.joint_element[j];
        double R[9], turn[9], product[9];
        mukca_rotation_from_rpy(R, chain.element[k].rpy);
        mukca_rotation_about(turn, chain.element[k].axis, turned[j]);
        mukca_mat3_mul(product, R, turn);
        mukca_rotation_to_rpy(offsets.theta + 6 * k + 3, product, NULL);
    }
    offsets.theta[6 * 2] += 0.01; /* the tool is no joint's */
    char *bytes = export("npy", MUKCA_OK);
    assert_memory_equal(bytes, header, sizeof header - 1);
    assert_int_equal(bytes[127], '\n');
    for (int j = 0; j < 2; j++) {
        double zero;
        memcpy(&zero, bytes + 128 + 8 * j, sizeof zero); /* on a little-endian machine */
        assert_close(zero, turned[j], 1e-9);
    }
    assert_part(notes, "npy: offsets of the joints alone were fitted");
    assert_part(notes, "differs by 10.000 mm"); /* the tool is not exported */
    free(bytes);
}

TEST(mjcf_holds_springs_and_names_the_rest)
{
    add_effects();
    char *text = export("mjcf", MUKCA_OK);
    assert_part(notes, "joint_scale of a is not exported: the format mjcf");
    assert_null(strstr(notes, "joint_compliance"));
    assert_part(text, "name=\"b_flex\" type=\"hinge\" axis=\"0 1 0\" stiffness=\"10000\"");
    free(text);
}

/* A stop is a joint's: an effect at none has no element to put it in, whatever its kind. */
TEST(mjcf_refuses_play_at_no_joint)
{
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
        const mukca_effect effect = make_effect((mukca_effect_kind)kind, -1, 1e-3);
        const bool at_base = mukca_effect_table[kind]->site == MUKCA_SITE_BASE &&
                             (mukca_effect_table[kind]->traits & MUKCA_TRAIT_ELASTIC);
        assert_int_equal(mukca_export_mjcf.holds(&effect), at_base);
    }
}

TEST_EACH(setup, scratch_teardown)
