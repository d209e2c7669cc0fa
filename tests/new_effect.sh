#!/bin/bash
# A new effect is one new file and one row of the catalogue: adds a toy effect to a copy of the
# sources, simulates a session with it, and has `diagnose` name it at the right joint.
set -eu
cd "$(dirname "$0")/.."
. tests/ok.bash
build=${BUILD:-$PWD/build}
cp -r Makefile src include tools "$dir"
mkdir "$dir/build"
cp "$build/config.mk" "$dir/build"
cp data/demo/arm.urdf "$dir"
cd "$dir"

cat >src/effect/joint_quadratic.c <<'EOF'
/* A toy: the error of the angle grows with the square of the angle. */
#include "effect/catalogue.h"

static void basis(double basis[][3], const mukca_basis_input *in)
{
    const double q = in->state->q[in->effect->joint];
    basis[0][0] = q * q;
}

static int by_angle(double slope[][3], const mukca_basis_input *in, const double value[][3])
{
    (void)value;
    slope[0][0] = 2 * in->state->q[in->effect->joint];
    return 0;
}

const mukca_effect_ops mukca_joint_quadratic_effect = {
    .info = {.name = "joint_quadratic",
             .title = "quadratic angle error",
             .site = MUKCA_SITE_ANGLE,
             .terms = 1,
             .unit = "rad/rad^2",
             .traits = MUKCA_TRAIT_OWN_ANGLE | MUKCA_TRAIT_SMOOTH,
             .sentence = "the error of the angle grows with its square"},
    .basis = basis,
    .by_angle = by_angle,
    .candidate = mukca_survey_moved,
};
EOF
sed -i 's/^\( *\)X(JOINT_SCALE, joint_scale) *\\$/&\n\1X(JOINT_QUADRATIC, joint_quadratic) \\/' include/mukca/effect.h
ok "the program builds with a new effect" make -s BUILD=build OPTIMISE=-O0 HARDENING= build/mukca
build/mukca simulate --urdf arm.urdf --seed 5 --noise 5e-5 --rows 30 --perturb 1,2 -q \
    --effect joint_quadratic:joint_3=1.5e-3 --truth truth.tsv -o session.tsv
build/mukca diagnose --urdf arm.urdf session.tsv -q --json - >diagnosis.json || true
tr -d '\n' <diagnosis.json | sed 's/.*"causes": *\[//; s/}.*//' >first_cause
ok "diagnose names a new effect" grep -q '"effect": "joint_quadratic"' first_cause
ok "at its joint" grep -q '"joint": "joint_3"' first_cause
ok "an offsets table holds it" grep -q "^joint_3	joint_quadratic	rad/rad^2	" truth.tsv
build/mukca help effects >effects
ok "help lists it" grep -q '^joint_quadratic (rad/rad^2)' effects
ok "fk applies it" build/mukca fk --urdf arm.urdf --offsets truth.tsv session.tsv
exit $failed
