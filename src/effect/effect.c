/* Forward models of the catalogue's effects. */
#include "mukca/effect.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const mukca_effect_info mukca_effect_table[MUKCA_EFFECT_COUNT] = {
#define ROW(kind, name, site, terms, unit, factor, display, nonnegative, needs, sentence) \
    {name, MUKCA_SITE_##site, terms, unit, factor, display, nonnegative, needs, sentence},
    MUKCA_EFFECT_LIST(ROW)
#undef ROW
};

int mukca_effect_find(const char *name)
{
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++)
        if (!strcmp(mukca_effect_table[kind].name, name)) return kind;
    return -1;
}

int mukca_effect_terms(mukca_effect_kind kind, int variant)
{
    if (kind == MUKCA_EFFECT_AXIS_WOBBLE && variant > 50) return 2;
    return mukca_effect_table[kind].terms;
}

/* Four harmonics about the two transverse axes, in the frame before (variant 1, 2) or after
 * (11, 12) the turn, or a cone (100 + k): k = 0 and 1 would be geometry. */
static void wobble_basis(double basis[MUKCA_MAX_TERMS][3], int variant, const double axis[3],
                         double q)
{
    double e[2][3];
    mukca_rotation_transverse(e[0], e[1], axis);
    if (variant > 50) {
        const double s = sin((variant - 100) * q), c = cos((variant - 100) * q);
        for (int i = 0; i < 3; i++) {
            basis[0][i] = c * e[0][i] + s * e[1][i];
            basis[1][i] = c * e[1][i] - s * e[0][i];
        }
        return;
    }
    const int order = variant > 10 ? variant - 10 : variant;
    const double s = sin(order * q), c = cos(order * q);
    if (variant > 10) {
        double R[9], u[3];
        mukca_rotation_about(R, axis, q);
        for (int a = 0; a < 2; a++) {
            memcpy(u, e[a], sizeof u);
            mukca_mat3_vec(e[a], R, u);
        }
    }
    for (int i = 0; i < 3; i++) {
        basis[0][i] = s * e[0][i], basis[1][i] = c * e[0][i];
        basis[2][i] = s * e[1][i], basis[3][i] = c * e[1][i];
    }
}

void mukca_effect_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                        const double axis[3], const mukca_joint_state *state)
{
    const int j = effect->joint;
    memset(basis, 0, MUKCA_MAX_TERMS * sizeof *basis);
    switch (effect->kind) {
        case MUKCA_EFFECT_JOINT_COMPLIANCE:
            if (state->torque) basis[0][0] = -state->torque[j];
            break;
        case MUKCA_EFFECT_LINK_BENDING:
            if (state->moment) {
                const double along = mukca_dot3(state->moment[j], axis);
                for (int i = 0; i < 3; i++) basis[0][i] = along * axis[i] - state->moment[j][i];
            }
            break;
        case MUKCA_EFFECT_BASE_COMPLIANCE:
            if (state->base_moment)
                for (int i = 0; i < 3; i++) basis[0][i] = -state->base_moment[i];
            break;
        case MUKCA_EFFECT_BACKLASH:
            if (state->torque)
                basis[0][0] = -0.5 * tanh(state->torque[j] / (1e-3 * effect->variant));
            break;
        case MUKCA_EFFECT_APPROACH_HYSTERESIS:
            if (state->move) basis[0][0] = -0.5 * tanh(state->move[j] / 0.02);
            break;
        case MUKCA_EFFECT_JOINT_SCALE:
            basis[0][0] = state->q[j];
            break;
        case MUKCA_EFFECT_JOINT_COUPLING:
            basis[0][0] = state->q[j + effect->variant];
            break;
        case MUKCA_EFFECT_ENCODER_ECCENTRICITY:
            basis[0][0] = sin(state->q[j]), basis[1][0] = cos(state->q[j]);
            break;
        case MUKCA_EFFECT_GEAR_HARMONIC:
            basis[0][0] = sin(effect->variant * state->q[j]);
            basis[1][0] = cos(effect->variant * state->q[j]);
            break;
        case MUKCA_EFFECT_AXIS_WOBBLE:
            wobble_basis(basis, effect->variant, axis, state->q[j]);
            break;
        case MUKCA_EFFECT_JOINT_DRIFT:
            basis[0][0] =
                effect->variant > 0 ? 1 - exp(-state->time / effect->variant) : 1e-3 * state->time;
            break;
        case MUKCA_EFFECT_ZERO_JUMP:
            basis[0][0] = effect->placement >= 0 && state->placement == effect->placement;
            break;
        case MUKCA_EFFECT_BALL_SHIFT:
            if (effect->placement >= 0 && state->placement == effect->placement)
                basis[0][0] = basis[1][1] = basis[2][2] = 1;
            break;
        case MUKCA_EFFECT_READBACK_LAG:
        case MUKCA_EFFECT_TOOL_MOTION:
        case MUKCA_EFFECT_SOCKET_DISTANCE:
        case MUKCA_EFFECT_COUNT:
            break;
    }
}

void mukca_effect_lag_direction(double *direction, int n_joints, int variant,
                                const mukca_joint_state *state)
{
    double largest = 0;
    memset(direction, 0, (size_t)n_joints * sizeof *direction);
    if (variant == 1) {
        if (state->command)
            for (int j = 0; j < n_joints; j++) direction[j] = state->command[j] - state->q[j];
        return;
    }
    if (!state->move) return;
    for (int j = 0; j < n_joints; j++) largest = fmax(largest, fabs(state->move[j]));
    if (largest > 1e-9)
        for (int j = 0; j < n_joints; j++) direction[j] = state->move[j] / largest;
}

void mukca_effect_apply(mukca_displacement *displacement, const mukca_effect *effect,
                        const mukca_chain *chain, const mukca_joint_state *state)
{
    const int j = effect->joint;
    double basis[MUKCA_MAX_TERMS][3], direction[MUKCA_MAX_JOINTS];
    double *into = displacement->tip;
    switch (mukca_effect_table[effect->kind].site) {
        case MUKCA_SITE_ANGLES:
            mukca_effect_lag_direction(direction, chain->n_joints, effect->variant, state);
            for (int i = 0; i < chain->n_joints; i++)
                displacement->q[i] += effect->coefficient[0] * direction[i];
            return;
        case MUKCA_SITE_SOCKET:
            return;
        case MUKCA_SITE_ANGLE:
            into = &displacement->q[j];
            break;
        case MUKCA_SITE_ROTATION:
            into = displacement->rotation[j];
            displacement->any_rotation = true;
            break;
        case MUKCA_SITE_BASE:
            into = displacement->base;
            displacement->any_rotation = true;
            break;
        case MUKCA_SITE_TIP:
            break;
    }
    static const double none[3] = {0, 0, 0};
    const double *axis = j >= 0 ? chain->element[chain->joint_element[j]].axis : none;
    const int width = mukca_effect_table[effect->kind].site == MUKCA_SITE_ANGLE ? 1 : 3;
    mukca_effect_basis(basis, effect, axis, state);
    for (int t = 0; t < effect->terms; t++)
        for (int i = 0; i < width; i++) into[i] += effect->coefficient[t] * basis[t][i];
}

/* The geometry as the displacement leaves it (angles aside), for the moments there. */
static void bend_geometry(mukca_geometry *bent, const mukca_geometry *geometry,
                          const mukca_displacement *displacement)
{
    mukca_frame tilt = {.p = {0, 0, 0}};
    *bent = *geometry;
    if (!displacement->any_rotation) return;
    for (int k = 0; k < geometry->n_elements; k++) {
        if (geometry->joint[k] < 0) continue;
        double R[9];
        mukca_rotation_exp(R, displacement->rotation[geometry->joint[k]]);
        mukca_mat3_mul(bent->origin[k].R, geometry->origin[k].R, R);
    }
    mukca_rotation_exp(tilt.R, displacement->base);
    if (geometry->n_elements > 0) mukca_frame_multiply(&bent->origin[0], &tilt, &bent->origin[0]);
}

/* Largest difference between two displacements' angles and rotations. */
static double change(const mukca_displacement *a, const mukca_displacement *b, int n_joints)
{
    double largest = 0;
    for (int j = 0; j < n_joints; j++) {
        largest = fmax(largest, fabs(a->q[j] - b->q[j]));
        for (int i = 0; i < 3; i++)
            largest = fmax(largest, fabs(a->rotation[j][i] - b->rotation[j][i]));
    }
    for (int i = 0; i < 3; i++) largest = fmax(largest, fabs(a->base[i] - b->base[i]));
    return largest;
}

void mukca_effects_displacement(mukca_displacement *displacement, const mukca_effect *effects,
                                int n, const mukca_chain *chain, const mukca_geometry *geometry,
                                const double *q, const mukca_joint_state *state)
{
    enum { ROUNDS = 8 };
    mukca_joint_state full = {.placement = -1};
    double moment[MUKCA_MAX_JOINTS][3], torque[MUKCA_MAX_JOINTS], base[3];
    int needs = 0;
    if (state) full = *state;
    full.q = q;
    for (int i = 0; i < n; i++) needs |= mukca_effect_table[effects[i].kind].needs;
    const bool loaded = (needs & MUKCA_NEEDS_MASSES) && !full.torque;
    if (loaded) {
        mukca_chain_moments(moment, torque, base, chain, geometry, q, NULL, full.payload_kg);
        full.torque = torque;
        full.moment = (const double(*)[3])moment;
        full.base_moment = base;
    }
    mukca_displacement before = {0};
    for (int round = 0; round < ROUNDS; round++) {
        memset(displacement, 0, sizeof *displacement);
        for (int i = 0; i < n; i++) mukca_effect_apply(displacement, &effects[i], chain, &full);
        if (!loaded || change(displacement, &before, chain->n_joints) < 1e-12) return;
        /* Once more under the load of the arm where it has come to: the equilibrium. */
        mukca_geometry bent;
        double angle[MUKCA_MAX_JOINTS];
        before = *displacement;
        bend_geometry(&bent, geometry, displacement);
        for (int j = 0; j < chain->n_joints; j++) angle[j] = q[j] + displacement->q[j];
        mukca_chain_moments(moment, torque, base, chain, &bent, angle, NULL, full.payload_kg);
    }
}

static const char *const axis_letter[3] = {"x", "y", "z"};

void mukca_effect_term_text(char text[48], const mukca_effect *effect, int term)
{
    const char *wave = term % 2 ? "cos" : "sin";
    text[0] = '\0';
    switch (effect->kind) {
        case MUKCA_EFFECT_BACKLASH:
            snprintf(text, 48, "torque_scale=%dmNm", effect->variant);
            break;
        case MUKCA_EFFECT_JOINT_COUPLING:
            snprintf(text, 48, "neighbour=%+d", effect->variant);
            break;
        case MUKCA_EFFECT_ENCODER_ECCENTRICITY:
            snprintf(text, 48, "%s", wave);
            break;
        case MUKCA_EFFECT_GEAR_HARMONIC:
            snprintf(text, 48, "order=%d %s", effect->variant, wave);
            break;
        case MUKCA_EFFECT_AXIS_WOBBLE:
            snprintf(text, 48, "variant=%d term=%d", effect->variant, term);
            break;
        case MUKCA_EFFECT_JOINT_DRIFT:
            snprintf(text, 48, "time_constant=%ds", effect->variant);
            break;
        case MUKCA_EFFECT_READBACK_LAG:
            snprintf(text, 48, "%s", effect->variant ? "command" : "move");
            break;
        case MUKCA_EFFECT_ZERO_JUMP:
            snprintf(text, 48, "placement=%d", effect->placement);
            break;
        case MUKCA_EFFECT_BALL_SHIFT:
            snprintf(text, 48, "placement=%d %s", effect->placement, axis_letter[term % 3]);
            break;
        default:
            snprintf(text, 48, "-");
            break;
    }
}

int mukca_effect_term_parse(mukca_effect *effect, const char *text)
{
    char word[8] = "";
    int term = 0, end = 0;
    effect->variant = 0;
    effect->placement = -1;
    switch (effect->kind) {
        case MUKCA_EFFECT_BACKLASH:
            if (sscanf(text, "torque_scale=%dmNm%n", &effect->variant, &end) != 1 || !end)
                return -1;
            if (effect->variant <= 0) return -1;
            break;
        case MUKCA_EFFECT_JOINT_COUPLING:
            if (sscanf(text, "neighbour=%d%n", &effect->variant, &end) != 1) return -1;
            if (effect->variant != 1 && effect->variant != -1) return -1;
            break;
        case MUKCA_EFFECT_ENCODER_ECCENTRICITY:
            if (sscanf(text, "%3s%n", word, &end) != 1) return -1;
            break;
        case MUKCA_EFFECT_GEAR_HARMONIC:
            if (sscanf(text, "order=%d %3s%n", &effect->variant, word, &end) != 2) return -1;
            if (effect->variant < 2 || effect->variant > 400) return -1;
            break;
        case MUKCA_EFFECT_AXIS_WOBBLE:
            if (sscanf(text, "variant=%d term=%d%n", &effect->variant, &term, &end) != 2) return -1;
            if (effect->variant < 1 || effect->variant > 110 || term < 0) return -1;
            break;
        case MUKCA_EFFECT_JOINT_DRIFT:
            if (sscanf(text, "time_constant=%ds%n", &effect->variant, &end) != 1 || !end) return -1;
            if (effect->variant < 0) return -1;
            break;
        case MUKCA_EFFECT_READBACK_LAG:
            effect->variant = !strcmp(text, "command");
            if (!effect->variant && strcmp(text, "move") != 0) return -1;
            end = (int)strlen(text);
            break;
        case MUKCA_EFFECT_ZERO_JUMP:
            if (sscanf(text, "placement=%d%n", &effect->placement, &end) != 1) return -1;
            break;
        case MUKCA_EFFECT_BALL_SHIFT:
            if (sscanf(text, "placement=%d %1s%n", &effect->placement, word, &end) != 2) return -1;
            for (term = 0; term < 3 && strcmp(word, axis_letter[term]) != 0; term++) continue;
            break;
        default:
            if (strcmp(text, "-") != 0) return -1;
            end = 1;
            break;
    }
    if (effect->kind == MUKCA_EFFECT_GEAR_HARMONIC ||
        effect->kind == MUKCA_EFFECT_ENCODER_ECCENTRICITY) {
        if (strcmp(word, "sin") != 0 && strcmp(word, "cos") != 0) return -1;
        term = !strcmp(word, "cos");
    }
    effect->terms = mukca_effect_terms(effect->kind, effect->variant);
    return text[end] == '\0' && term < effect->terms ? term : -1;
}
