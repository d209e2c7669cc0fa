/* The offsets table: what is written is read back to the last bit, and never for another arm. */
#include "io/offsets.h"

#include "arm/tip_change.h"
#include "arms.h"
#include "mukca/corrected.h"

#include "odd_urdf.h"

static mukca_offsets offsets, back;

static int setup(void **state)
{
    if (scratch_setup(state) || mukca_urdf_load(&chain, urdf_path(), NULL, &error)) return 1;
    mukca_random random = mukca_random_seeded(3);
    mukca_offsets_init(&offsets, &chain);
    for (int i = 0; i < 18; i++) {
        offsets.theta[i] += 1e-3 * mukca_random_normal(&random);
        offsets.sigma[i] = i == 4 ? HUGE_VAL : 1e-5 * (i + 1);
        offsets.identifiable[i] = i != 4;
        offsets.listed[i] = 1;
    }
    return 0;
}

static void add_effect(mukca_effect_kind kind, int joint, int placement, const char *variant)
{
    mukca_effect *e = &offsets.effects[offsets.n_effects];
    *e = (mukca_effect){.kind = kind, .joint = joint, .placement = placement};
    assert_null(mukca_effect_set_variant(e, variant, chain.n_joints));
    for (int t = 0; t < e->terms; t++) {
        e->coefficient[t] = 1e-3 / 3 * (t + 1 + offsets.n_effects);
        offsets.effect_sigma[offsets.n_effects][t] = 1e-6 * (t + 1);
    }
    offsets.n_effects++;
}

static void add_effects(void)
{
    add_effect(MUKCA_EFFECT_JOINT_COMPLIANCE, 1, -1, NULL);
    add_effect(MUKCA_EFFECT_BASE_COMPLIANCE, -1, -1, NULL);
    add_effect(MUKCA_EFFECT_GEAR_HARMONIC, 0, -1, "240");
    add_effect(MUKCA_EFFECT_GEAR_HARMONIC, 0, -1, "120");
    add_effect(MUKCA_EFFECT_AXIS_WOBBLE, 1, -1, "turning2");
    add_effect(MUKCA_EFFECT_BACKLASH, 0, -1, "300");
    add_effect(MUKCA_EFFECT_JOINT_DRIFT, 0, -1, "1000");
    add_effect(MUKCA_EFFECT_READBACK_LAG, -1, -1, "command");
    add_effect(MUKCA_EFFECT_ZERO_JUMP, 1, 2, NULL);
    add_effect(MUKCA_EFFECT_BALL_SHIFT, -1, 0, NULL);
    static const char *const names[] = {"front", "back left", "high"};
    offsets.n_placements = 3;
    for (int p = 0; p < 3; p++) snprintf(offsets.placements[p], MUKCA_NAME_SIZE, "%s", names[p]);
}

/* Write the table; its path. */
static const char *write_table(void)
{
    const char *path;
    FILE *file = scratch_create(&path, "offsets.tsv");
    assert_ok(mukca_offsets_write(file, &offsets, &chain, NULL, "one\ntwo", &error));
    fclose(file);
    return path;
}

static mukca_status read_table(const char *path, bool other)
{
    notes[0] = error.text[0] = '\0';
    return mukca_offsets_read(
        &back, &chain, path,
        &(mukca_offsets_options){.accept = other ? MUKCA_ACCEPT_OTHER : 0, .notes = {note, NULL}},
        &error);
}

TEST(tables_come_back_to_the_last_bit)
{
    add_effects();
    mukca_acceptance *verdict = &offsets.acceptance;
    verdict->given = verdict->accepted = verdict->converged = true;
    snprintf(verdict->error_of, sizeof verdict->error_of, "test data, 60 samples");
    snprintf(verdict->at_rest, sizeof verdict->at_rest, "a, b");
    verdict->error_m = 2.5e-4;
    assert_ok(read_table(write_table(), false));
    assert_string_equal(notes, "");
    assert_true(back.acceptance.given && back.acceptance.accepted && back.acceptance.converged);
    assert_string_equal(back.acceptance.error_of, "test data, 60 samples");
    assert_string_equal(back.acceptance.at_rest, "a, b");
    assert_true(back.acceptance.error_m == 2.5e-4);
    assert_true(isnan(back.acceptance.tip_change_m)); /* not known, not written */
    assert_memory_equal(back.theta, offsets.theta, sizeof back.theta);
    assert_memory_equal(back.sigma, offsets.sigma, sizeof back.sigma);
    assert_memory_equal(back.listed, offsets.listed, sizeof back.listed);
    assert_memory_equal(back.identifiable, offsets.identifiable, sizeof back.identifiable);
    assert_int_equal(back.n_effects, offsets.n_effects);
    for (int e = 0; e < back.n_effects; e++) {
        const mukca_effect *a = &back.effects[e], *b = &offsets.effects[e];
        assert_true(mukca_effect_same(a, b));
        assert_int_equal(a->terms, b->terms);
        for (int t = 0; t < a->terms; t++) {
            assert_true(a->coefficient[t] == b->coefficient[t]);
            assert_true(back.effect_sigma[e][t] == offsets.effect_sigma[e][t]);
        }
    }
    assert_string_equal(back.placements[1], "back left");
    /* in another dataset the placements have other numbers */
    mukca_placement named[2] = {{"high"}, {"front"}};
    const mukca_dataset data = {.n_placements = 2, .placements = named};
    mukca_effect placed[MUKCA_MAX_EFFECTS];
    mukca_offsets_place_effects(placed, &back, &data);
    assert_int_equal(placed[8].placement, 0);
    assert_int_equal(placed[9].placement, 1);
    named[0].name[0] = 'x';
    mukca_offsets_place_effects(placed, &back, &data);
    assert_int_equal(placed[8].placement, -1);
}

TEST(controllers_get_no_failed_table)
{
    mukca_corrected *model = zeroed(1, sizeof *model);
    const char *path = write_table();
    assert_ok(mukca_corrected_load(model, path, &error)); /* an older table */
    assert_false(model->judged);
    mukca_acceptance_refuse(&offsets.acceptance, "moves the tip by %d mm", 551);
    assert_refused(mukca_corrected_load(model, write_table(), &error),
                   "did not pass: moves the tip by 551 mm");
    assert_true(model->judged && !model->accepted);
    assert_int_equal(read_table(path, false), MUKCA_INPUT);
    offsets.acceptance.accepted = true;
    offsets.acceptance.reason[0] = '\0';
    assert_ok(mukca_corrected_load(model, write_table(), &error));
    assert_true(model->judged && model->accepted && model->intact);
    free(model);
}

/* A table that is cut anywhere, or with any byte changed, is refused; both as bytes and as a file.
 */
TEST(edited_tables_are_refused)
{
    mukca_corrected *model = zeroed(1, sizeof *model);
    add_effects();
    mukca_acceptance *verdict = &offsets.acceptance;
    verdict->given = verdict->accepted = verdict->converged = true;
    verdict->error_nominal_m = 5e-3, verdict->error_m = 2e-4;
    char *text = scratch_read(write_table());
    const size_t size = strlen(text);
    assert_ok(mukca_corrected_parse(model, text, size, &error));
    for (size_t n = 0; n < size; n++)
        assert_int_equal(mukca_corrected_parse(model, text, n, &error), MUKCA_INPUT);
    for (char *at = strstr(text, "# digest: ") + 10; *at; at++) {
        *at ^= 1;
        assert_int_equal(mukca_corrected_parse(model, text, size, &error), MUKCA_INPUT);
        *at ^= 1;
    }
    char *digest = strstr(text, "# digest: ") + 10;
    *digest = *digest == '0' ? '1' : '0';
    assert_ok(mukca_corrected_parse_named(model, text, size, "table", MUKCA_ACCEPT_EDITED, &error));
    assert_true(model->judged && !model->accepted && !model->intact);
    const char *path = scratch_file("edited.tsv", text);
    assert_refused(read_table(path, false), "was edited or cut");
    assert_refused(read_table(path, true), "was edited or cut");
    free(model);
    free(text);
}

/* One joint about z turned by 10 mrad moves a tip at a radius r by 10e-3 r. */
TEST(the_tip_change_is_measured)
{
    static mukca_offsets turned;
    static const double one[2][6] = {{0}, {0.5, 0, 0.2}}, two[3][6] = {{0}, {10}, {0.5, 0, 0.2}};
    mukca_chain arm, longer;
    mukca_tip_change change;
    make_chain(&arm, "RF", one, "a", 1);
    mukca_offsets_init(&turned, &arm);
    turned.theta[5] = 10e-3;
    turned.listed[5] = 1;
    const mukca_tip_change_task task = {.chain = &arm, .to = &turned};
    assert_ok(mukca_tip_change_find(&change, &task, NULL));
    assert_close(change.m, 2 * 0.5 * sin(5e-3), 1e-12);
    assert_close(change.size, 0, 1e-12); /* a zero turns the workspace */
    const mukca_tip_change_task back_task = {.chain = &arm, .from = &turned, .to = &turned};
    assert_ok(mukca_tip_change_find(&change, &back_task, NULL));
    assert_true(change.m < 1e-15);
    assert_ok(mukca_tip_change_judge(&turned, &task, NULL));
    assert_true(turned.acceptance.largest_offset_rad == 10e-3);
    assert_true(turned.acceptance.largest_offset_m == 0);
    turned.theta[MUKCA_PARAMETERS] = 0.505;
    assert_ok(mukca_tip_change_find(&change, &task, NULL));
    assert_close(change.size, 0, 1e-12); /* nor does a tool change the arm */
    make_chain(&longer, "RRF", two, "a", 1);
    mukca_offsets_init(&turned, &longer);
    turned.theta[MUKCA_PARAMETERS] = 10.1;
    const mukca_tip_change_task longer_task = {.chain = &longer, .to = &turned};
    assert_ok(mukca_tip_change_find(&change, &longer_task, NULL));
    assert_close(change.size, 0.01, 1e-3);
}

TEST(tables_tell_where_they_come_from)
{
    setenv("SOURCE_DATE_EPOCH", "86400", 1);
    char *text = scratch_read(write_table());
    unsetenv("SOURCE_DATE_EPOCH");
    static const char *const parts[] = {
        "# mukca ",
        "# digest: ",
        " offsets table\n",
        "# robot: odd & arm\n",
        "# urdf_sha256: ",
        "# base: base\n",
        "# tip: ball\n",
        "# created: 1970-01-02T00:00:00Z\n",
        "# one\n# two\n",
        "# formula: calibrated = nominal + offset;",
        "\njoint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm\n",
        "\na\tpitch\trad\t1.5\t",
        "\tinf\t0\t-\n"};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) assert_part(text, parts[i]);
    free(text);
}

TEST(another_arms_table_is_refused)
{
    const char *path = write_table();
    char *text = scratch_read(path);
    strstr(text, "# urdf_sha256: ")[20] ^= 1;
    memcpy(strstr(text, "# digest"), "# d     ", 8); /* as if made by hand */
    path = scratch_file("other.tsv", text);
    free(text);
    assert_refused(read_table(path, false), "was made for another URDF");
    assert_ok(read_table(path, true));
    assert_part(notes, "made for another URDF");
    /* forced onto another nominal model it is the offsets that count */
    const double was = chain.element[0].xyz[0];
    chain.element[0].xyz[0] = 5;
    assert_ok(read_table(path, true));
    assert_close(back.theta[0], 5 + offsets.theta[0] - was, 1e-15);
    assert_true(back.theta[1] == offsets.theta[1]);
}

TEST(broken_tables_get_one_clear_line)
{
    static const bad_text cases[] = {
        {"a\tx\tm\t0\t0\t1\t0\t1\t-", "column 'calibrated': is not nominal + offset"},
        {"a\tx\tm\t1e300\t0\t-1e300\t0\t1\t-", "column 'offset': is larger than any arm's"},
        {"a\tx\tm\t0\tnan\t1\t0\t1\t-", "'nan' is not a finite number"},
        {"a\tx\tm\t0\t1\t1\tbig\t1\t-", "column 'sigma': 'big'"},
        {"a\tx\tm\t0.1\t1.1\t1\t0\t1\t-\na\tx\tm\t0.1\t1.1\t1\t0\t1\t-", "comes twice"},
        {"a\tx\tmm\t0\t1\t1\t0\t1\t-", "column 'unit': is 'mm'; convert the row to m"},
        {"a\tyaw\tdeg\t0\t1\t1\t0\t1\t-", "column 'unit': is 'deg'; convert the row to rad"},
        {"a\twidth\tm\t0\t1\t1\t0\t1\t-", "neither a parameter nor an effect"},
        {"q\tbacklash\trad\t0\t1\t1\t0\t1\ttorque_scale=300mNm", "no such joint"},
        {"a\tbacklash\trad\t0\t1\t1\t0\t1\tplacement=0", "column 'term': does not fit"},
        {"a\tgear_harmonic\trad\t0\t1\t1\t0\t1\torder=900 sin", "does not fit"},
        {"a\tzero_jump\trad\t0\t1\t1\t0\t1\tplacement=64", "does not fit"},
        {"-\ttool_motion\tm\t0\t1\t1\t0\t1\t-", "recording fault"},
        {"a\tx\tm\t0", "4 columns, but 9"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[600];
        snprintf(text, sizeof text,
                 "# urdf_sha256: %s\njoint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\t"
                 "identifiable\tterm\n%s\n",
                 chain.urdf_sha256, cases[i].text);
        assert_refused(read_table(scratch_file("b.tsv", text), false), cases[i].part);
    }
    assert_refused(read_table(scratch_file("b.tsv", "joint\tparameter\n"), false),
                   "`# urdf_sha256:` is missing");
    char text[200];
    snprintf(text, sizeof text, "# urdf_sha256: %s\njoint\tparameter\n", chain.urdf_sha256);
    assert_refused(read_table(scratch_file("b.tsv", text), false), "no column 'nominal'");
}

TEST_EACH(setup, scratch_teardown)
