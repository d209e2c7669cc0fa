/* Parser of `mukca simulate --effect`, driven by the table of effects. */
#include "cli/simulate.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"
#include "dynamics/inverse_dynamics.h"

enum { TEXT = 160, MAX_VALUES = 4 };

/* One specification, split into its parts. */
typedef struct {
    char name[TEXT], where[TEXT], variant[TEXT]; /* empty: not given */
    double value[MAX_VALUES];
    int n_values;
    const char *text; /* the whole text, for messages */
    mukca_error *error;
} piece;

/* Recording faults at samples of a socket. */
typedef struct {
    const char *name;
    mukca_simulated_fault_kind kind;
    bool sized, creeps;
    int first_row;
} fault_kind;

static const fault_kind faults[] = {{"tool_motion", MUKCA_SIMULATED_STEP, true, true, 1},
                                    {"wrong_socket", MUKCA_SIMULATED_WRONG_SOCKET, false, false, 1},
                                    {"outlier", MUKCA_SIMULATED_OUTLIER, true, false, 1},
                                    {"duplicate", MUKCA_SIMULATED_DUPLICATE, false, false, 2}};

static const fault_kind *find_fault(const char *name)
{
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++)
        if (strcmp(faults[i].name, name) == 0) return &faults[i];
    return NULL;
}

__attribute__((format(printf, 2, 3))) static mukca_status wrong(const piece *p, const char *format,
                                                                ...)
{
    char why[320];
    va_list args;
    va_start(args, format);
    vsnprintf(why, sizeof why, format, args);
    va_end(args);
    return mukca_fail(p->error, MUKCA_USAGE, "--effect %.80s: %s", p->text, why);
}

/* Text up to one of `stops`; longer text is truncated, and then matches no name. */
static const char *take(char *out, const char *from, const char *stops)
{
    size_t length = strcspn(from, stops);
    snprintf(out, TEXT, "%.*s", (int)(length < TEXT ? length : TEXT - 1), from);
    return from + length;
}

/* Split the next specification off *text. */
static mukca_status split(piece *p, const char **text, mukca_error *error)
{
    const char *at = *text;
    *p = (piece){.text = *text, .error = error};
    at = take(p->name, at, ":@=,");
    if (*at == ':') at = take(p->where, at + 1, "@=,");
    if (*at == '@') at = take(p->variant, at + 1, "=,");
    while (*at == (p->n_values ? ',' : '=')) {
        char number[TEXT];
        double value;
        const char *next = take(number, at + 1, ",");
        if (!mukca_number_parse(&value, number)) {
            if (p->n_values) break; /* next specification */
            return wrong(p, "a number must follow the =");
        }
        if (fabs(value) > MUKCA_NUMBER_LARGEST) return wrong(p, "is larger than any arm's");
        if (p->n_values == MAX_VALUES) return wrong(p, "too many values");
        p->value[p->n_values++] = value;
        at = next;
    }
    if (*at == ',' && at[1] == '\0') return wrong(p, "ends in a comma");
    *text = *at == ',' ? at + 1 : at;
    return MUKCA_OK;
}

static mukca_status find_joint(int *joint, const cli_simulated *s, const piece *p, const char *name)
{
    *joint = mukca_chain_find_joint(s->chain, name);
    if (*joint >= 0) return MUKCA_OK;
    return wrong(p, "no joint '%.40s' in the chain; the first one is '%s'", name,
                 mukca_chain_joint_name(s->chain, 0));
}

static mukca_status find_placement(int *placement, const cli_simulated *s, const piece *p,
                                   const char *name)
{
    for (*placement = 0; *placement < s->n_places; ++*placement)
        if (strcmp(s->places[*placement].name, name) == 0) return MUKCA_OK;
    if (!s->n_places) return wrong(p, "a pose log has no placements and no sockets");
    return wrong(p, "no placement '%.40s'; the first one is '%s'", name, s->places[0].name);
}

/* PLACEMENT/SOCKET and @ROW of a fault. */
static mukca_status find_seat(mukca_simulated_fault *fault, const cli_simulated *s, const piece *p,
                              const fault_kind *kind)
{
    char name[TEXT];
    double row = 1;
    const char *slash = strrchr(p->where, '/');
    if (!slash || (strcmp(slash, "/0") != 0 && strcmp(slash, "/1") != 0))
        return wrong(p, "needs NAME:PLACEMENT/SOCKET@ROW, socket 0 or 1");
    snprintf(name, sizeof name, "%.*s", (int)(slash - p->where), p->where);
    MUKCA_TRY(find_placement(&fault->placement, s, p, name));
    fault->socket = slash[1] - '0';
    if (kind->creeps && strcmp(p->variant, "creep") == 0)
        fault->kind = MUKCA_SIMULATED_CREEP;
    else if (!mukca_number_parse(&row, p->variant) || row != floor(row) || row < kind->first_row ||
             row > s->rows)
        return wrong(p, "@ROW must be a sample of the socket, %d to %d%s", kind->first_row, s->rows,
                     kind->creeps ? ", or creep" : "");
    fault->row = (int)row - 1;
    return MUKCA_OK;
}

/* Draw a vector of that length in a random direction. */
static void draw_vector(double *vector, int n, double length, mukca_random *random)
{
    double size = 0;
    while (size == 0) {
        for (int i = 0; i < n; i++) vector[i] = mukca_random_normal(random);
        for (int i = 0; i < n; i++) size = hypot(size, vector[i]);
    }
    for (int i = 0; i < n; i++) vector[i] *= length / size;
}

static mukca_status add_fault(cli_simulated *s, const piece *p, const fault_kind *kind)
{
    mukca_simulated_fault fault = {.kind = kind->kind};
    if (s->n_faults == CLI_MAX_SIMULATED_FAULTS) return wrong(p, "too many faults");
    MUKCA_TRY(find_seat(&fault, s, p, kind));
    if (p->n_values != 0 && !kind->sized) return wrong(p, "has no size");
    if (kind->sized && p->n_values != 1 && p->n_values != 3)
        return wrong(p, "needs its size in m: =LENGTH or =X,Y,Z");
    if (p->n_values == 1) draw_vector(fault.shift, 3, p->value[0], &s->random);
    if (p->n_values == 3) memcpy(fault.shift, p->value, sizeof fault.shift);
    s->faults[s->n_faults++] = fault;
    return MUKCA_OK;
}

static mukca_status set_place(mukca_effect *effect, const cli_simulated *s, const piece *p)
{
    const bool jointed = mukca_effect_has_joint((int)effect->kind);
    const bool placed = mukca_effect_table[effect->kind]->needs & MUKCA_NEEDS_PLACEMENTS;
    char joint[TEXT];
    const char *slash = strrchr(p->where, '/');
    if (!jointed && !placed) return p->where[0] ? wrong(p, "acts at no joint") : MUKCA_OK;
    if (!jointed) return find_placement(&effect->placement, s, p, p->where);
    memcpy(joint, p->where, sizeof joint);
    if (placed) {
        if (!slash) return wrong(p, "needs a joint and a placement: NAME:JOINT/PLACEMENT");
        joint[slash - p->where] = '\0';
        MUKCA_TRY(find_placement(&effect->placement, s, p, slash + 1));
    }
    if (!joint[0]) return wrong(p, "needs a joint: NAME:JOINT=VALUE");
    return find_joint(&effect->joint, s, p, joint);
}

static mukca_status set_values(mukca_effect *effect, cli_simulated *s, const piece *p)
{
    const mukca_effect_info *info = mukca_effect_table[effect->kind];
    if (p->n_values == 0) return wrong(p, "needs =VALUE in %s", info->unit);
    if (p->n_values != 1 && p->n_values != effect->terms)
        return wrong(p, "needs 1 or %d values", effect->terms);
    if (info->nonnegative && p->value[0] < 0)
        return wrong(p, "cannot be negative: the load is gravity's");
    if (p->n_values == effect->terms) {
        memcpy(effect->coefficient, p->value, sizeof effect->coefficient);
    } else if (effect->terms == 4) { /* circular motion of the axis: one wave in both directions */
        double wave[2] = {0, 0};
        draw_vector(wave, 2, p->value[0], &s->random);
        effect->coefficient[0] = -wave[1], effect->coefficient[1] = wave[0];
        effect->coefficient[2] = wave[0], effect->coefficient[3] = wave[1];
    } else {
        draw_vector(effect->coefficient, effect->terms, p->value[0], &s->random);
    }
    return MUKCA_OK;
}

static mukca_status add_effect(cli_simulated *s, const piece *p, mukca_effect_kind kind)
{
    mukca_effect effect = {.kind = kind, .joint = -1, .placement = -1};
    if (s->n_effects == MUKCA_MAX_EFFECTS) return wrong(p, "too many effects");
    if (!s->n_places && (mukca_effect_table[kind]->needs & MUKCA_NEEDS_SOCKETS))
        return wrong(p, "a pose log has no placements and no sockets");
    if ((mukca_effect_table[kind]->needs & MUKCA_NEEDS_MASSES) && !s->chain->n_masses)
        return wrong(p, "needs link masses; give --inertials FILE");
    MUKCA_TRY(set_place(&effect, s, p));
    const char *expected =
        mukca_effect_set_variant(&effect, p->variant[0] ? p->variant : NULL, s->chain->n_joints);
    if (expected) return wrong(p, "expected %s", expected);
    MUKCA_TRY(set_values(&effect, s, p));
    s->effects[s->n_effects++] = effect;
    return MUKCA_OK;
}

/* ---- effects of a moving arm ---- */

/* A link must have a mass, and must keep one. */
static mukca_status check_mass(const cli_simulated *s, const mukca_simulated_torque *t,
                               const piece *p)
{
    double inertial[MUKCA_MAX_JOINTS * MUKCA_INERTIAL];
    if (t->joint < 0 || !mukca_simulated_kinds[t->kind].masses) return MUKCA_OK;
    mukca_dynamics_inertials(inertial, s->chain);
    const double kg = inertial[MUKCA_INERTIAL * t->joint];
    if (!(kg > 0)) return wrong(p, "this link has no mass; give --inertials FILE");
    return p->n_values > 1 || kg + t->value[0] > 0 ? MUKCA_OK : wrong(p, "leaves the link no mass");
}

static mukca_status add_torque(cli_simulated *s, const piece *p)
{
    mukca_simulated_torque t = {.kind = mukca_simulated_kind_find(p->name), .joint = -1};
    if (t.kind < 0)
        return wrong(p, "is no effect of a moving arm; `mukca simulate --help` lists them");
    const mukca_simulated_kind *kind = &mukca_simulated_kinds[t.kind];
    if (s->n_torques == CLI_MAX_SIMULATED_TORQUES) return wrong(p, "too many effects");
    if (kind->where == MUKCA_SIMULATED_AT_TIP && p->where[0])
        return wrong(p, "is at the tip: NAME=VALUE");
    if (kind->where == MUKCA_SIMULATED_AT_JOINT && !p->where[0])
        return wrong(p, "needs a joint: NAME:JOINT=VALUE");
    MUKCA_TRY(p->where[0] ? find_joint(&t.joint, s, p, p->where) : MUKCA_OK);
    const mukca_simulated_value *variant = &kind->variant;
    t.variant = kind->usual;
    if (!variant->name && p->variant[0]) return wrong(p, "has no @");
    if (variant->name && ((p->variant[0] && !mukca_number_parse(&t.variant, p->variant)) ||
                          !(t.variant > 0 && t.variant <= MUKCA_NUMBER_LARGEST)))
        return wrong(p, "@ needs its %s, above 0, in %s", variant->name, variant->unit);
    if (p->n_values != kind->least && p->n_values != kind->most)
        return wrong(p, "needs %d%s values, the first in %s", kind->least,
                     kind->most > kind->least ? " or more" : "", kind->value[0].unit);
    memcpy(t.value, p->value, sizeof t.value);
    MUKCA_TRY(check_mass(s, &t, p));
    s->torques[s->n_torques++] = t;
    return MUKCA_OK;
}

mukca_status cli_simulated_parse(cli_simulated *s, const char *text, mukca_error *error)
{
    do {
        piece p;
        MUKCA_TRY(split(&p, &text, error));
        const int kind = mukca_effect_find(p.name);
        const fault_kind *fault = find_fault(p.name);
        MUKCA_TRY(s->moves    ? add_torque(s, &p)
                  : fault     ? add_fault(s, &p, fault)
                  : kind >= 0 ? add_effect(s, &p, (mukca_effect_kind)kind)
                              : cli_fail_effect(error, "--effect", p.name));
    } while (*text);
    return MUKCA_OK;
}

/* ---- placements ---- */

mukca_status cli_read_place(mukca_place *place, const char *text, mukca_error *error)
{
    double v[6] = {0};
    const size_t length = strcspn(text, "=");
    if (length == 0 || length >= sizeof place->name || strcspn(text, "\t,#/ ") < length)
        return mukca_fail(error, MUKCA_USAGE, "--place %.80s: begins with no usable name", text);
    memcpy(place->name, text, length);
    if (!text[length]) return MUKCA_OK;
    const int n = cli_read_list(v, 6, text + length + 1);
    if (n != 3 && n != 6)
        return mukca_fail(error, MUKCA_USAGE,
                          "--place %.80s: needs NAME=X,Y,Z or NAME=X,Y,Z,ROLL,PITCH,YAW", text);
    memcpy(place->pose.p, v, sizeof place->pose.p);
    mukca_rotation_from_rpy(place->pose.R, v + 3);
    place->placed = true;
    return MUKCA_OK;
}
