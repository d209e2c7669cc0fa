/* LCM messages of every type, ours included, from bytes that nobody vouches for. */
#include "lcm/message.h"
#include "lcm/packet.h"
#include "lcm/type.h"
#include "memory_file.h"

/* A type that nests, recurs and repeats, besides the built-in ones. */
static const char description[] =
    "package f; struct joint { string name; float q; } struct arm { int64_t utime; int8_t n;"
    " joint joints[n]; arm more[n]; int16_t a; int16_t b; double m[a][b]; byte raw[3]; }";

static const mukca_lcm_types *get_types(void)
{
    static mukca_lcm_types types;
    mukca_error error;
    if (types.n_types) return &types;
    if (mukca_lcm_types_init(&types, &error) ||
        mukca_lcm_types_parse(&types, description, "f", &error) ||
        mukca_lcm_type_set_role(&types, types.n_types - 1, MUKCA_LCM_ROLE_POSITION, "joints.q",
                                &error) ||
        mukca_lcm_type_set_role(&types, types.n_types - 1, MUKCA_LCM_ROLE_NAME, "joints.name",
                                &error))
        abort();
    return &types;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static union {
#define MEMBER(channel, name, fingerprint) mukca_message_##name name;
        MUKCA_MESSAGE_LIST(MEMBER)
    } message;
    static const uint64_t own[] = {
#define FINGERPRINT(channel, name, fingerprint) fingerprint,
        MUKCA_MESSAGE_LIST(FINGERPRINT)};
    const mukca_lcm_types *types = get_types();
    mukca_error error = {MUKCA_OK, ""};
    if (size < 9) return 0;
    /* the first byte chooses the type, so that its fingerprint need not be found by luck */
    int kind = bytes[0] % (types->n_types + MUKCA_MESSAGES) - MUKCA_LCM_STATES;
    int t = kind < 0 ? kind + MUKCA_LCM_STATES : kind - MUKCA_MESSAGES + MUKCA_LCM_STATES;
    bool ours = kind >= 0 && kind < MUKCA_MESSAGES;
    unsigned char *copy = malloc(size + 7);
    if (!copy) return 0;
    mukca_lcm_wire_put(copy, ours ? own[kind] : types->type[t].fingerprint, 8);
    memcpy(copy + 8, bytes + 1, size - 1);
    if (ours) {
        /* what was decoded encodes to as many bytes, unless flags and texts were odd */
        mukca_message_kind k = (mukca_message_kind)kind;
        if (!mukca_message_identify(copy, size + 7)) abort();
        if (!mukca_message_decode(&message, k, copy, size + 7, &error) &&
            mukca_message_encode(NULL, 0, k, &message) > size + 7)
            abort();
    } else if (mukca_lcm_types_find(types, copy, size + 7) != t) {
        abort();
    } else if (mukca_lcm_type_has_joints(types, t)) {
        mukca_lcm_joints joints;
        if (!mukca_lcm_decode_joints(&joints, types, t, copy, size + 7, &error)) {
            if (joints.n < 1 || joints.n > MUKCA_LCM_MAX_JOINTS) abort();
            for (int j = 0; j < joints.n; j++) {
                if (!isfinite(joints.value[MUKCA_LCM_ROLE_POSITION][j])) abort();
                if (joints.has[MUKCA_LCM_ROLE_NAME] && strlen(joints.name[j]) > size) abort();
            }
        } else if (!error.text[0]) {
            abort();
        }
    }
    free(copy);
    return 0;
}
