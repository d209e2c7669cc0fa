/* A diagnosis hands over every key of the contract's JSON, and a screen of at most 79 columns. */
#include "cli/diagnose.h"

#include "diagnosed.h"

static void assert_keys(json_t *object, const char *keys)
{
    char list[512];
    assert_true(json_is_object(object));
    snprintf(list, sizeof list, "%s", keys);
    for (char *key = strtok(list, " "); key; key = strtok(NULL, " "))
        if (!json_object_get(object, key)) fail_msg("no key '%s'", key);
}

static double real(json_t *object, const char *key)
{
    json_t *value = json_object_get(object, key);
    assert_true(json_is_number(value));
    return json_number_value(value);
}

static const char *text(json_t *object, const char *key)
{
    const char *value = json_string_value(json_object_get(object, key));
    assert_non_null(value);
    return value;
}

/* Every key, type and range that scripts rely on. */
static void check_json(json_t *root, const mukca_chain *chain)
{
    size_t i;
    json_t *item, *tie;
    assert_keys(
        root,
        "verdict findings maybe unexplained causes data_faults gap test where tested next_poses "
        "elapsed_s");
    assert_true(strstr("none named tied unknown untestable", text(root, "verdict")));
    assert_true(json_is_boolean(json_object_get(root, "unexplained")));
    json_array_foreach(json_object_get(root, "findings"), i, item)
    {
        assert_keys(item,
                    "kind effect varies_with from to placement order order_ci95 probability halves "
                    "halves_against "
                    "size_m size_ci95_m share held_out coefficient alternatives sentence");
        assert_true(real(item, "probability") >= 0.95 && real(item, "halves") >= 0.7);
        assert_true(json_array_size(json_object_get(item, "alternatives")) >= 1);
        text(item, "sentence");
    }
    json_array_foreach(json_object_get(root, "causes"), i, item)
    {
        assert_keys(item,
                    "effect joint placement socket row order amplitude unit ci95 log_bayes_factor "
                    "probability ties held_out");
        const int kind = mukca_effect_find(text(item, "effect"));
        assert_true(kind >= 0);
        assert_string_equal(text(item, "unit"), mukca_effect_table[kind]->unit);
        json_t *joint = json_object_get(item, "joint");
        assert_true(json_is_null(joint) ||
                    mukca_chain_find_joint(chain, json_string_value(joint)) >= 0);
        const double p = real(item, "probability");
        assert_true(p >= 0 && p <= 1);
        json_t *ci = json_object_get(item, "ci95");
        assert_int_equal(json_array_size(ci), 2);
        assert_true(json_number_value(json_array_get(ci, 0)) <= real(item, "amplitude"));
        assert_true(json_number_value(json_array_get(ci, 1)) >= real(item, "amplitude"));
        json_t *held_out = json_object_get(item, "held_out");
        if (!json_is_null(held_out))
            assert_keys(held_out, "before_m after_m shrink_percent ci95 folds_better folds");
        for (size_t k = 0; k < json_array_size(json_object_get(item, "ties")); k++) {
            tie = json_array_get(json_object_get(item, "ties"), k);
            assert_keys(tie, "effect joint log_bayes_factor correlation");
        }
    }
    json_array_foreach(json_object_get(root, "data_faults"), i, item)
    {
        assert_keys(item, "kind placement socket row size_m");
        assert_true(strstr("tool_motion wrong_socket outlier duplicate", text(item, "kind")));
        assert_true(real(item, "row") >= 1);
    }
    assert_keys(json_object_get(root, "gap"),
                "nominal_m geometry_m faults_excused_m explained_m noise_floor_m folds");
    json_t *where = json_object_get(root, "where");
    assert_keys(where, "joints placements axes");
    assert_int_equal(json_array_size(json_object_get(where, "axes")), 3);
    json_array_foreach(json_object_get(where, "joints"), i, item)
        assert_keys(item, "joint share range_rad");
    json_array_foreach(json_object_get(where, "placements"), i, item)
        assert_keys(item, "placement mae_m");
    json_array_foreach(json_object_get(root, "tested"), i, item)
    {
        assert_keys(item, "effect joint log_bayes_factor testable why");
        if (!json_boolean_value(json_object_get(item, "testable"))) text(item, "why");
    }
}

/* The diagnosis as JSON, which holds to the contract. */
static json_t *to_json(const mukca_diagnosed *result)
{
    json_t *root = cli_diagnosis_json(result);
    check_json(root, result->chain);
    return root;
}

/* The screen as text; no line wider than 79 columns, no number that is none. */
static char *screen(const mukca_diagnosed *result)
{
    const char *path;
    FILE *file = scratch_create(&path, "screen");
    cli_diagnosis_print(file, result, false);
    fclose(file);
    char *all = scratch_read(path);
    for (const char *line = all; *line;) {
        const size_t length = strcspn(line, "\n");
        if (length > 79) fail_msg("too wide: %.*s", (int)length, line);
        line += length + (line[length] == '\n');
    }
    assert_null(strstr(all, "nan"));
    assert_null(strstr(all, "inf "));
    return all;
}

TEST(everything_is_handed_over)
{
    mukca_dataset test;
    simulate(
        "joint_compliance:joint_2=3e-5,gear_harmonic:joint_4@160=1e-3,"
        "tool_motion:left/1@14=1.2e-3,outlier:high/0@7=8e-3,wrong_socket:right/0@5",
        11);
    s.how.effort = true;
    record_again();
    s.how.seed = 12;
    s.hidden.n_faults = 0;
    record_at(&test, &s, 2);
    diagnose((mukca_diagnose_options){.applied = true, .test = &test});
    const mukca_diagnosed result = {
        .diagnosis = d, .chain = &s.chain, .data = &data, .test = &test};
    json_t *root = to_json(&result);
    json_t *gap = json_object_get(root, "gap");
    assert_true(real(gap, "nominal_m") > real(gap, "geometry_m"));
    assert_true(real(gap, "geometry_m") > real(gap, "faults_excused_m"));
    assert_true(real(gap, "faults_excused_m") > real(gap, "explained_m"));
    assert_close(real(gap, "noise_floor_m"), 1.596e-4, 0.1e-4);
    assert_true(real(json_object_get(root, "test"), "explained_m") <
                0.8 * real(json_object_get(root, "test"), "geometry_m"));
    /* simulated rows lie one after the other: 30 for each socket */
    int seen = 0;
    size_t i;
    json_t *fault;
    json_array_foreach(json_object_get(root, "data_faults"), i, fault)
    {
        const char *kind = text(fault, "kind");
        const int row = (int)real(fault, "row");
        if (!strcmp(kind, "tool_motion")) {
            assert_true(abs(row - (3 * 30 + 14)) <= 3);
            assert_string_equal(text(fault, "placement"), "left");
            seen |= 1;
        } else if (!strcmp(kind, "outlier") && row == 6 * 30 + 7) {
            assert_close(real(fault, "size_m"), 8e-3, 1e-3);
            seen |= 2;
        } else if (!strcmp(kind, "wrong_socket")) {
            assert_int_equal(row, 4 * 30 + 5);
            assert_close(real(fault, "size_m"), 0.05, 10e-3); /* at the nominal geometry */
            seen |= 4;
        }
    }
    assert_int_equal(seen, 7);
    json_decref(root);

    char *all = screen(&result);
    static const char *const parts[] = {"joint compliance at joint_2",
                                        "transmission ripple at joint_4, order 160 ",
                                        "urad/(N·m) [",
                                        "mrad [",
                                        "left, socket 1, row 10",
                                        "record this socket again",
                                        "right, socket 0, row 125",
                                        "correct its label",
                                        "mm held out (geometry alone ",
                                        "; test"};
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) assert_part(all, parts[k]);
    free(all);
    mukca_dataset_free(&test);
}

/* Diagnose; the verdict in JSON, and words on the screen. */
static json_t *diagnosed_as(const char *verdict, const char *words)
{
    diagnose((mukca_diagnose_options){.applied = true});
    const mukca_diagnosed result = {.diagnosis = d, .chain = &s.chain, .data = &data};
    char *all = screen(&result);
    assert_part(all, words);
    free(all);
    json_t *root = to_json(&result);
    assert_string_equal(text(root, "verdict"), verdict);
    return root;
}

TEST(noise_is_called_noise)
{
    simulate(NULL, 11);
    json_t *root = diagnosed_as("none", "Nothing beyond the geometry: ");
    assert_true(json_is_null(json_object_get(root, "test")));
    json_decref(root);
}

/* Rows of nothing: the same keys, the reason in words. */
TEST(nothing_to_test)
{
    set_scene(&s, NULL, 11);
    s.how.rows = 2;
    record_again();
    memset(data.q, 0, (size_t)(data.n_rows * data.n_joints) * sizeof *data.q);
    json_t *root = diagnosed_as("untestable", "Nothing can be tested: too few different samples");
    assert_int_equal(json_array_size(json_object_get(root, "tested")), MUKCA_EFFECT_COUNT);
    json_decref(root);
}

/* The table lacks the causes of a tied verdict that raise the error of test data. */
TEST(tied_causes_are_possible_and_no_table_corrects_them)
{
    mukca_diagnosis tied = {.verdict = MUKCA_VERDICT_TIED, .n_causes = 2};
    mukca_cause *const causes = tied.causes;
    causes[0].effect = (mukca_effect){.kind = MUKCA_EFFECT_BACKLASH, .placement = -1};
    causes[1].effect = (mukca_effect){.kind = MUKCA_EFFECT_JOINT_SCALE, .placement = -1};
    causes[1].n_ties = 1;
    tied.test_geometry_m = 1e-4;
    tied.test_explained_m = 2e-4;
    const mukca_diagnosed r = {.diagnosis = &tied, .chain = &s.chain, .data = &data};
    for (int i = 0; i < 2; i++)
        assert_null(strstr(mukca_wording_remedy(&causes[i], &r), "compensate"));
    assert_part(mukca_wording_verdict(MUKCA_WORDS, &r), "Nothing for sure");
}

/* A statement about what finer ones in its range, or one outside the catalogue, leave says so. */
TEST(beside_finer_findings)
{
    static mukca_diagnosis empty;
    const mukca_diagnosed r = {.diagnosis = &empty, .chain = &s.chain, .data = &data};
    mukca_finding f = {.group = {.kind = MUKCA_GROUP_FAMILY,
                                 .family = MUKCA_VARIES_LOAD,
                                 .effect = -1,
                                 .from = -1,
                                 .n_finer = 1},
                       .alternatives = {{.family = MUKCA_VARIES_TIME, .probability = 0.5}},
                       .n_alternatives = 1};
    assert_part(mukca_wording_finding(MUKCA_WORDS, &f, &r), "further deflection under load, base");
    f.group.family = MUKCA_VARIES_TIME;
    assert_part(mukca_wording_finding(MUKCA_WORDS, &f, &r), "also drifts with time, base");
    f.group.kind = MUKCA_GROUP_PLACE;
    assert_part(mukca_wording_alternatives(MUKCA_WORDS, &f, &r), "catalogue (time)");
    f.group.probability = f.group.halves = 1;
    assert_part(mukca_wording_certainty(MUKCA_WORDS, &f, &r), "certain (> 99.9 %, all halves)");
    f.group.beside_unknown = true;
    assert_part(mukca_wording_certainty(MUKCA_WORDS, &f, &r),
                "sure (> 99.9 %, all halves), or left by a larger cause outside the catalogue");
}

TEST_MAIN(set_up, tear_down)
