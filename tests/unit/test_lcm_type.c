/* LCM messages: fingerprints are lcm-gen's, descriptions are read or refused with their place,
 * and no message makes the decoder read beyond it. */
#include "base/text.h"
#include "close.h"
#include "lcm/message.h"
#include "lcm/type.h"

static mukca_lcm_types types, more; /* built in; and described by a test */

FIXTURE(setup)
{
    if (mukca_lcm_types_init(&types, &error)) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    return 0;
}

static mukca_status describe(const char *text)
{
    more = types;
    return mukca_lcm_types_parse(&more, text, "x.lcm", &error);
}

/* What lcm-gen 1.3.1 prints for the public descriptions: the rows' own column. */
TEST(fingerprints_of_the_table)
{
    static const struct {
        const char *name;
        uint64_t fingerprint;
    } rows[] = {
#define ROW(file, type, channel, fingerprint) {type, fingerprint},
        MUKCA_LCM_STATE_LIST(ROW)};
    assert_int_equal(types.n_types, MUKCA_LCM_STATES);
    for (int t = 0; t < MUKCA_LCM_STATES; t++) {
        assert_string_equal(types.type[t].name, rows[t].name);
        if (types.type[t].fingerprint != rows[t].fingerprint)
            fail_msg("%s: %016llx", rows[t].name, (unsigned long long)types.type[t].fingerprint);
    }
}

/* Nested, recursive and many-dimensional types; the numbers are lcm-gen's. */
static const char description[] =
    "package tt; struct inner_t { int32_t k; double v[k]; string s; }\n"
    "struct outer_t { /* block\n comment */ const int32_t N = 7, M = 0x3; const double PI = 3.14;\n"
    "  int64_t utime; // c\n  inner_t head; tt.inner_t list[3]; double q[7]; int8_t rows;\n"
    "  int16_t cols; float m[rows][cols][2]; byte raw[3]; boolean ok; byte hx[0x04]; }\n"
    "struct rec_t { int32_t n; rec_t child[n]; int8_t x; }\n"
    "struct multi_t { double a, b[2], c; }\n";

TEST(fingerprints_of_descriptions)
{
    static const uint64_t expected[] = {0xe91bf74449e1007d, 0xf308ee7639972379, 0xad74a06faabc875e,
                                        0xb215bfa80228ad15};
    assert_ok(describe(description));
    assert_int_equal(more.n_types, types.n_types + 4);
    for (int i = 0; i < 4; i++)
        assert_true(more.type[types.n_types + i].fingerprint == expected[i]);
}

/* Every error names file, line and column, and leaves the table as it was. */
TEST(bad_descriptions)
{
    static const bad_text cases[] = {
        {"", "describes no struct"},
        {"package a;\nstruct b {\n  double q[n];\n}", "x.lcm:3:12: the array size is no integer"},
        {"struct b { double n; double q[n]; }", "x.lcm:1:31: the array size is no integer"},
        {"struct b { double q[0]; }", "bad array size"},
        {"struct b { double q[2][2][2][2]; }", "too many dimensions"},
        {"struct b { other_t x; }", "field x of b is a other_t, which neither this file"},
        {"struct b { double q; double q; }", "the same field twice"},
        {"struct b { double q }", "expected \";\""},
        {"struct b { double q; ", "expected a name at the end"},
        {"enum e { A, B }", "enum is not understood"},
        {"struct b { enum e { A } x; }", "enum and struct inside"},
        {"struct 9b { }", "expected a name"},
        {"hello", "expected \"package\" or \"struct\" at \"hello\""},
        {"struct b { const int32_t A = 1", "expected \";\" at the end"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_refused(describe(cases[i].text), cases[i].part);
        assert_int_equal(more.n_types, types.n_types);
        assert_int_equal(more.n_fields, types.n_fields);
    }
}

/* ---- a writer that knows nothing of the decoder ---- */

typedef struct {
    unsigned char bytes[8192];
    size_t n;
} message;

static void put(message *m, uint64_t value, int size)
{
    while (size--) m->bytes[m->n++] = (unsigned char)(value >> 8 * size);
}

static void put_real(message *m, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put(m, bits, 8);
}

static void put_float(message *m, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put(m, bits, 4);
}

static void put_text(message *m, const char *text)
{
    put(m, strlen(text) + 1, 4);
    memcpy(m->bytes + m->n, text, strlen(text) + 1);
    m->n += strlen(text) + 1;
}

static int named(const char *name)
{
    int t = mukca_lcm_types_find_name(&types, name);
    assert_true(t >= 0);
    return t;
}

static const int64_t sent_at = 1700000000123456;

/* A number on the wire.  The time is sent_at, every count n; element j of
 * another field i is 100 i + j / 8. */
static void put_number(message *m, int t, int i, int j, int n)
{
    const mukca_lcm_type *type = &types.type[t];
    const mukca_lcm_field *field = &types.field[type->first_field + i];
    if (field->primitive == MUKCA_LCM_DOUBLE)
        put_real(m, 100 * i + j / 8.);
    else if (field->primitive == MUKCA_LCM_FLOAT)
        put_float(m, 100.f * (float)i + (float)j / 8);
    else
        put(m, i == type->role[MUKCA_LCM_ROLE_TIME][0] ? (uint64_t)sent_at : (uint64_t)n,
            mukca_lcm_primitive_sizes[field->primitive]);
}

/* A message of a row of the table with n joints. */
static void compose(message *m, int t, int n)
{
    const mukca_lcm_type *type = &types.type[t];
    m->n = 0;
    put(m, type->fingerprint, 8);
    for (int i = 0; i < type->n_fields; i++) {
        const mukca_lcm_field *field = &types.field[type->first_field + i];
        for (int j = 0; j < (field->n_dimensions ? n : 1); j++)
            if (field->primitive == MUKCA_LCM_STRING)
                put_text(m, (const char[]){'j', (char)('1' + j % 9), 0});
            else
                put_number(m, t, i, j, n);
    }
}

/* Whatever row the table gets: all that has a role comes out as it was sent. */
TEST(decodes_every_type)
{
    for (int t = 0; t < MUKCA_LCM_STATES; t++) {
        const mukca_lcm_type *type = &types.type[t];
        for (int n = 1; n <= 64; n += 9) {
            message m;
            mukca_lcm_joints joints;
            compose(&m, t, n);
            assert_int_equal(mukca_lcm_types_find(&types, m.bytes, m.n), t);
            if (mukca_lcm_decode_joints(&joints, &types, t, m.bytes, m.n, &error))
                fail_msg("%s: %s", type->name, error.text);
            assert_int_equal(joints.n, n);
            assert_true(joints.has[MUKCA_LCM_ROLE_POSITION]);
            assert_int_equal(joints.time, type->role[MUKCA_LCM_ROLE_TIME][0] >= 0 ? sent_at : 0);
            for (int r = MUKCA_LCM_ROLE_NAME; r < MUKCA_LCM_ROLES; r++) {
                int i = type->role[r][0];
                assert_int_equal(joints.has[r], i >= 0);
                double sign = r == MUKCA_LCM_ROLE_EFFORT ? type->effort_factor : 1;
                for (int j = 0; j < n && i >= 0; j++)
                    if (r == MUKCA_LCM_ROLE_NAME)
                        assert_int_equal(joints.name[j][1], '1' + j % 9);
                    else
                        assert_true(joints.value[r][j] == sign * (100 * i + j / 8.));
            }
        }
    }
}

/* Known of the drivers: sizes, and the sign of the torque (IIWA reports that of the load). */
TEST(facts_of_the_drivers)
{
    message m;
    compose(&m, named("drake.lcmt_iiwa_status"), 7);
    assert_int_equal(m.n, 20 + 56 * 7);
    compose(&m, named("drake.lcmt_panda_status"), 7);
    assert_int_equal(m.n, 38 + 64 * 7);
    assert_true(types.type[named("drake.lcmt_iiwa_status")].effort_factor == -1);
    assert_true(types.type[named("drake.lcmt_panda_status")].effort_factor == 1);
}

static mukca_status decode_copy(int t, const void *bytes, size_t n)
{
    mukca_lcm_joints joints;
    unsigned char *copy = copied(bytes, n);
    mukca_status status = mukca_lcm_decode_joints(&joints, &types, t, copy, n, &error);
    free(copy);
    return status;
}

TEST(refuses_hostile_messages)
{
    static const uint32_t counts[] = {0,          8,          65,         0x7fffffff, 0x80000000,
                                      0xffffffff, 0x10000000, 0x20000000, 0x24924924, 0x12492492};
    for (int t = 0; t < MUKCA_LCM_STATES; t++) {
        message m;
        compose(&m, t, 7);
        for (size_t cut = 0; cut < m.n; cut++)
            assert_int_equal(decode_copy(t, m.bytes, cut), MUKCA_INPUT);
        m.bytes[m.n] = 0;
        assert_int_equal(decode_copy(t, m.bytes, m.n + 1), MUKCA_INPUT);
        /* the count of joints follows the time, or a text of 3 bytes after it */
        const mukca_lcm_field *fields = &types.field[types.type[t].first_field];
        bool text = fields[1].primitive == MUKCA_LCM_STRING;
        size_t at = text ? 23 : 16;
        int width = mukca_lcm_primitive_sizes[fields[text ? 2 : 1].primitive];
        for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
            for (int k = 0; k < width; k++)
                m.bytes[at + (size_t)k] = (unsigned char)(counts[i] >> 8 * (3 - k));
            assert_int_equal(decode_copy(t, m.bytes, m.n), MUKCA_INPUT);
        }
        compose(&m, t, 65); /* well formed, but more joints than an arm has */
        assert_int_equal(decode_copy(t, m.bytes, m.n), MUKCA_INPUT);
    }
    message m;
    int iiwa = named("drake.lcmt_iiwa_status");
    compose(&m, iiwa, 7);
    size_t end = m.n;
    m.n = 20 + 8 * 2;
    put_real(&m, (double)NAN);
    assert_refused(decode_copy(iiwa, m.bytes, end), "position 3 is no finite number");
}

/* Positions inside nested structs, one by one. */
TEST(decodes_nested_positions)
{
    static const char text[] =
        "package u; struct joint { string name; float q; } struct head { int64_t seq; }\n"
        "struct arm { head h; int8_t n; joint joints[n]; int64_t utime; }";
    assert_ok(describe(text));
    int t = types.n_types + 2;
    assert_ok(mukca_lcm_type_set_role(&more, t, MUKCA_LCM_ROLE_POSITION, "joints.q", &error));
    assert_ok(mukca_lcm_type_set_role(&more, t, MUKCA_LCM_ROLE_NAME, "joints.name", &error));
    assert_ok(mukca_lcm_type_set_role(&more, t, MUKCA_LCM_ROLE_TIME, "utime", &error));
    message m = {.n = 0};
    put(&m, more.type[t].fingerprint, 8);
    put(&m, 5, 8);
    put(&m, 3, 1);
    for (int j = 0; j < 3; j++) {
        put_text(&m, "ab");
        put_float(&m, (float)j + 0.5f);
    }
    put(&m, 12345, 8);
    mukca_lcm_joints joints;
    assert_ok(mukca_lcm_decode_joints(&joints, &more, t, m.bytes, m.n, &error));
    assert_int_equal(joints.n, 3);
    assert_true(joints.value[MUKCA_LCM_ROLE_POSITION][2] == 2.5);
    assert_string_equal(joints.name[1], "ab");
    assert_true(joints.time == 12345);

    static const bad_text bad[] = {
        {"nothing", "has no field \"nothing\"; its fields: h n joints utime"},
        {"joints", "is a struct: name a field of it"},
        {"joints.name", "is a text, not a number"},
        {"n.x", "field n of u.arm"}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_refused(
            mukca_lcm_type_set_role(&more, t, MUKCA_LCM_ROLE_POSITION, bad[i].text, &error),
            bad[i].part);
    }
}

/* A struct that takes no bytes, or holds itself, costs no more time than its message is long. */
TEST(empty_and_recursive_types_are_bounded)
{
    static const char text[] =
        "struct none { } struct a { int32_t n; none x[n]; double q; }\n"
        "struct r { int8_t n; r child[n]; double q; }";
    mukca_lcm_joints joints;
    assert_ok(describe(text));
    for (int t = types.n_types + 1; t < more.n_types; t++)
        assert_ok(mukca_lcm_type_set_role(&more, t, MUKCA_LCM_ROLE_POSITION, "q", &error));
    message m = {.n = 8};
    put(&m, 0x7fffffff, 4);
    put_real(&m, 1);
    assert_int_equal(
        mukca_lcm_decode_joints(&joints, &more, types.n_types + 1, m.bytes, m.n, &error),
        MUKCA_INPUT);
    memset(m.bytes, 1, sizeof m.bytes); /* each r holds one r holds one r ... */
    assert_refused(
        mukca_lcm_decode_joints(&joints, &more, types.n_types + 2, m.bytes, sizeof m.bytes, &error),
        "nested more than");
}

/* Our own messages: every field comes back, any cut is refused, an encoder short of room says how
 * much it needs. */
TEST(own_messages_round_trip)
{
    static unsigned char buffer[1 << 20];
    static mukca_message_result result, back;
    result = (mukca_message_result){.utime = -5,
                                    .id = 1LL << 60,
                                    .verb = "calibrate",
                                    .code = 1,
                                    .text = "t",
                                    .json = "{}",
                                    .n = 3};
    for (int i = 0; i < 3; i++) {
        result.joint[i] = "A1";
        result.parameter[i] = "roll";
        result.unit[i] = "rad";
        result.offset[i] = 0.1 * i;
        result.sigma[i] = (double)INFINITY;
        result.identifiable[i] = i == 1;
    }
    size_t n = mukca_message_encode(buffer, sizeof buffer, MUKCA_MESSAGE_RESULT, &result);
    assert_true(n > 0);
    assert_int_equal(mukca_message_encode(NULL, 0, MUKCA_MESSAGE_RESULT, &result), n);
    assert_ok(mukca_message_decode(&back, MUKCA_MESSAGE_RESULT, buffer, n, &error));
    assert_true(back.utime == -5 && back.id == 1LL << 60 && back.code == 1 && back.n == 3);
    assert_string_equal(back.verb, "calibrate");
    assert_string_equal(back.robot, "");
    assert_string_equal(back.parameter[2], "roll");
    assert_true(back.offset[2] == 0.1 * 2 && isinf(back.sigma[0]) && back.identifiable[1]);
    assert_string_equal(back.json, "{}");
    for (size_t cut = 0; cut < n; cut++) {
        unsigned char *copy = copied(buffer, cut);
        assert_int_equal(mukca_message_decode(&back, MUKCA_MESSAGE_RESULT, copy, cut, &error),
                         MUKCA_INPUT);
        free(copy);
    }
    assert_int_equal(mukca_message_decode(&back, MUKCA_MESSAGE_SAMPLE, buffer, n, &error),
                     MUKCA_INPUT);
    result.n = MUKCA_MESSAGE_ROWS + 1;
    assert_int_equal(mukca_message_encode(NULL, 0, MUKCA_MESSAGE_RESULT, &result), 0);
}

/* The members of a struct as its description in LCM's language. */
#define LCM_NAME(type) \
    _Generic((type *)NULL, int64_t *: "int64_t", int *: "int32_t", double *: "double",         \
             bool *: "boolean", const char **: "string")
#define ONE(of, type, name) mukca_text_put(text, " %s %s;", LCM_NAME(type), #name);
#define MANY(of, type, name, capacity)                             \
    if (counted)                                                   \
        mukca_text_put(text, " %s %s[n];", LCM_NAME(type), #name); \
    else                                                           \
        mukca_text_put(text, " %s %s[%d];", LCM_NAME(type), #name, (int)(capacity));

static void describe_own(mukca_text *text, mukca_message_kind kind)
{
    const bool counted = kind != MUKCA_MESSAGE_POSE;
    switch (kind) {
#define CASE(channel, name, fingerprint)                           \
    case MUKCA_MESSAGE_##channel:                                  \
        mukca_text_put(text, "package mukca; struct %s {", #name); \
        MUKCA_MESSAGE_##channel##_LIST(ONE, MANY, ) break;
        MUKCA_MESSAGE_LIST(CASE)
        default:
            break;
    }
    mukca_text_put(text, " }");
}

/* The structs of message.h against the installed descriptions: fingerprints, and the decoder that
 * goes by a description reads what the encoder wrote. */
TEST(own_messages_are_those_of_data_lcm)
{
    static const char *const files[] = {
#define FILE_OF(channel, name, fingerprint) "data/lcm/mukca_" #name ".lcm",
        MUKCA_MESSAGE_LIST(FILE_OF)};
    static const uint64_t expected[] = {
#define FINGERPRINT(channel, name, fingerprint) fingerprint,
        MUKCA_MESSAGE_LIST(FINGERPRINT)};
    static union {
#define MEMBER(channel, name, fingerprint) mukca_message_##name name;
        MUKCA_MESSAGE_LIST(MEMBER)
    } zero;
    more = types;
    for (int k = 0; k < MUKCA_MESSAGES; k++) {
        unsigned char buffer[256];
        mukca_lcm_joints joints;
        assert_ok(mukca_lcm_types_read(&more, files[k], &error));
        int t = more.n_types - 1;
        assert_true(more.type[t].fingerprint == expected[k]);
        char own[2048] = "";
        mukca_text text = MUKCA_TEXT(own);
        describe_own(&text, (mukca_message_kind)k);
        assert_ok(mukca_lcm_types_parse(&more, own, "message.h", &error));
        assert_true(more.type[t + 1].fingerprint == expected[k]);
        assert_ok(mukca_lcm_type_set_role(&more, t, MUKCA_LCM_ROLE_POSITION, "utime", &error));
        memset(&zero, 0, sizeof zero);
        int64_t utime = 77 + k; /* the first member of each */
        memcpy(&zero, &utime, sizeof utime);
        size_t n = mukca_message_encode(buffer, sizeof buffer, (mukca_message_kind)k, &zero);
        assert_true(n > 8 && n <= sizeof buffer);
        assert_string_equal(mukca_message_identify(buffer, n), more.type[t].name);
        if (mukca_lcm_decode_joints(&joints, &more, t, buffer, n, &error))
            fail_msg("%s: %s", files[k], error.text);
        assert_true(joints.value[MUKCA_LCM_ROLE_POSITION][0] == 77 + k);
    }
    assert_null(mukca_message_identify("12345678", 8));
}

TEST_MAIN(setup, NULL)
