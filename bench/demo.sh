#!/usr/bin/env bash
# The demonstration behind `./dev demo`: calibrates and checks a simulated bench with unknown constants, runs a session
# of one virtual participant, and draws results and figures.
set -euo pipefail
cd "$(dirname "$0")/.."
program=${FRICTION_BENCH:-${CARGO_TARGET_DIR:-target}/release/friction-bench}
demo=${1:-demo}
if [ -e "$demo" ]; then
    n=2; while [ -e "$demo-$n" ]; do n=$((n + 1)); done
    demo=$demo-$n
fi
mkdir -p "$demo/calibration"

say() { printf '\n\033[1m%s\033[0m\n' "$*"; }
# The simulated bench's constants differ from its description; they come from the seed, and calibration must find them.
bench=(--mock bench-unknown --seed 7 --calibration "$demo/calibration/calibration.toml")
calibrate() { "$program" calibrate "$@" "${bench[@]}" --speed max --operator "the demonstration" --headless; }

say "Calibrate the inputs: gain, delay, noise  (friction-bench calibrate channels)"
calibrate channels
say "Calibrate the pickup against a vibrometer  (friction-bench calibrate pickup)"
calibrate pickup
say "Measure the plate: resonance, damping, force factor  (friction-bench calibrate plate)"
calibrate plate
say "Calibrate the force sensor with known masses  (friction-bench calibrate force)"
calibrate force --normal-g 20,50,100,200 --lateral-g 20,50,100

say "Check that the bench is connected, works, and is as calibrated  (friction-bench check)"
"$program" check "${bench[@]}" --protocol demo --study "$demo/study"

say "Run a session of one virtual participant, faster than real time  (friction-bench run)"
"$program" run "${bench[@]}" --speed max --headless --protocol demo --study "$demo/study" \
    --participant sub-01 --consent-by "the demonstration"

say "Analyse the recordings: impedance, gap, friction  (friction-bench analyze)"
"$program" analyze "$demo/study" --table --json "$demo/results.json" --figures "$demo/figures"

say "Results"
printf '  %s\n' \
    "$demo/calibration  the calibration and its figures" \
    "$demo/study        the recordings and the session's log" \
    "$demo/results.json the estimates of every instance by all three methods" \
    "$demo/figures      the published figures from these data"
printf '\nThe same session with the dashboard, in real time:\n'
printf '  %q run --mock --protocol demo --study %q/study --participant sub-02 --consent-by ME\n' "$program" "$demo"
