/* Mass, centre and inertia of a body: in other axes, and with more mass. */
#include "io/urdf.h"

#include <string.h>

#include "mukca/rotation.h"

static const int place[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}}; /* in six numbers of a tensor */

/* Inertia of a mass at a distance, added. */
static void add_point(double inertia[6], double kg, const double at[3])
{
    for (int a = 0; a < 3; a++)
        for (int b = a; b < 3; b++)
            inertia[place[a][b]] += kg * ((a == b ? mukca_dot3(at, at) : 0) - at[a] * at[b]);
}

bool mukca_tensor_positive(const double T[6])
{
    const double minor = T[0] * T[1] - T[3] * T[3];
    const double determinant =
        minor * T[2] - T[0] * T[5] * T[5] - T[1] * T[4] * T[4] + 2 * T[3] * T[4] * T[5];
    return T[0] > 0 && minor > 0 && determinant > 0;
}

void mukca_body_turn(mukca_mass *out, const mukca_mass *in, const double R[9])
{
    const double com[3] = {in->com[0], in->com[1], in->com[2]};
    double full[9], half[9];
    *out = *in;
    for (int a = 0; a < 9; a++) full[a] = in->inertia[place[a / 3][a % 3]];
    mukca_mat3_tmul(half, R, full);
    mukca_mat3_mul(full, half, R);
    for (int a = 0; a < 9; a++) out->inertia[place[a / 3][a % 3]] = full[a];
    mukca_mat3_tvec(out->com, R, com);
}

void mukca_body_add(mukca_mass *sum, const mukca_frame *T, const mukca_mass *body)
{
    const double kg = sum->kg + body->kg;
    mukca_mass turned;
    double back[9], d[3];
    if (body->kg == 0) return;
    for (int i = 0; i < 9; i++) back[i] = T->R[i % 3 * 3 + i / 3];
    mukca_body_turn(&turned, body, back);
    for (int i = 0; i < 3; i++) d[i] = turned.com[i] + T->p[i] - sum->com[i];
    add_point(sum->inertia, sum->kg * body->kg / kg, d); /* the reduced mass */
    for (int i = 0; i < 6; i++) sum->inertia[i] += turned.inertia[i];
    for (int i = 0; i < 3; i++) sum->com[i] += body->kg / kg * d[i];
    sum->kg = kg;
}

/* Whether a distribution of mass has this inertia: half of its trace minus it is positive. */
static bool is_physical(const double I[6])
{
    const double half = 0.5 * (I[0] + I[1] + I[2]);
    return mukca_tensor_positive(
        (double[]){half - I[0], half - I[1], half - I[2], -I[3], -I[4], -I[5]});
}

bool mukca_body_change(mukca_mass *b, const double d[10], bool tensor)
{
    const mukca_mass own = *b;
    double shift[3], centre[3], change[6];
    b->kg = own.kg + d[0];
    if (!(b->kg > 0)) return false;
    for (int i = 0; i < 3; i++) {
        b->com[i] = (own.kg * own.com[i] + d[1 + i]) / b->kg;
        shift[i] = own.com[i] - b->com[i];
        centre[i] = d[0] != 0 ? d[1 + i] / d[0] - b->com[i] : 0;
    }
    if (tensor) { /* about the frame's origin, then about the new centre */
        add_point(b->inertia, own.kg, own.com);
        for (int i = 0; i < 6; i++) b->inertia[i] += d[4 + i];
        add_point(b->inertia, -b->kg, b->com);
        if (is_physical(b->inertia)) return true;
    }
    memcpy(b->inertia, own.inertia, sizeof b->inertia);
    if (d[0] == 0) return true; /* its centre alone moves */
    memset(change, 0, sizeof change);
    add_point(change, own.kg, shift);
    add_point(change, d[0], centre);
    for (int i = 0; i < 6; i++) b->inertia[i] += change[i];
    if (is_physical(b->inertia)) return true;
    for (int i = 0; i < 6; i++) b->inertia[i] = own.inertia[i] * b->kg / own.kg;
    return true;
}
