#!/bin/sh
# Table I and the minima of the cost on the published robots' data, where those are at hand; data/panda
# contains the published values.
cd "$(dirname "$0")/.." || exit 1
if ! command -v python3 >/dev/null 2>&1; then
    echo "SKIPPED real_minima: no python3"
    exit 77
fi
out=$(python3 tools/verify_real.py --calibration) && status=0 || status=1
case $out in SKIPPED*)
    echo "$out"
    exit 77
    ;;
esac
(
    cd "${MUKCA_REAL_DATA:-../shared/real}/panda_3" || exit 1
    data=$OLDPWD/data/panda
    "$OLDPWD/tools/panda_session.py" frontcenter frontleft backcenter backleft | cmp - "$data/train.tsv" &&
        "$OLDPWD/tools/panda_session.py" frontright backright | cmp - "$data/test.tsv"
) || { echo "not ok data/panda: not the published recordings"; status=1; }
[ $status = 0 ] && echo "ok real_minima" && exit 0
echo "$out"
echo "not ok real_minima"
exit 1
