#!/bin/sh
# A new effect is one new file and one row of the catalogue: adds a toy effect to a copy of the
# sources, simulates a session with it, and has `diagnose` name it at the right joint.
set -eu
cd "$(dirname "$0")/.."
build=${BUILD:-$PWD/build}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cp -r Makefile src include tools "$scratch"
mkdir "$scratch/build"
cp "$build/config.mk" "$scratch/build"
cp data/demo/arm.urdf "$scratch"
cd "$scratch"

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
             .display_factor = 1e3,
             .display_unit = "mrad/rad^2",
             .traits = MUKCA_TRAIT_OWN_ANGLE | MUKCA_TRAIT_SMOOTH,
             .sentence = "the error of the angle grows with its square"},
    .basis = basis,
    .by_angle = by_angle,
    .candidate = mukca_survey_moved,
};
EOF
sed -i 's/^\( *\)X(JOINT_SCALE, joint_scale) *\\$/&\n\1X(JOINT_QUADRATIC, joint_quadratic) \\/' include/mukca/effect.h
if ! make -s BUILD=build OPTIMISE=-O0 HARDENING= build/mukca >log 2>&1; then
    echo "not ok the program builds with a new effect"
    cat log
    exit 1
fi

build/mukca simulate --urdf arm.urdf --seed 5 --noise 5e-5 --rows 30 --perturb 1,2 -q \
    --effect joint_quadratic:joint_3=1.5e-3 --truth truth.tsv -o session.tsv
build/mukca diagnose --urdf arm.urdf session.tsv -q --json - >diagnosis.json || true
fail=0
check() { # NAME PATTERN FILE
    if grep -q "$2" "$3"; then echo "ok $1"; else
        echo "not ok $1"
        fail=1
    fi
}
tr -d '\n' <diagnosis.json | sed 's/.*"causes": *\[//; s/}.*//' >first_cause
check "diagnose names a new effect" '"effect": "joint_quadratic"' first_cause
check "at its joint" '"joint": "joint_3"' first_cause
check "an offsets table holds it" "^joint_3	joint_quadratic	rad/rad^2	" truth.tsv
build/mukca help effects >effects
check "help lists it" '^joint_quadratic (rad/rad^2)' effects
build/mukca fk --urdf arm.urdf --offsets truth.tsv session.tsv >positions || fail=1
exit $fail
