#!/usr/bin/env bash
# The demonstration behind `./dev demo`: a bench that nobody knows is calibrated, checked, and used for a session of one virtual
# participant; then results and figures.
set -euo pipefail
cd "$(dirname "$0")/.."
program=${CARGO_TARGET_DIR:-target}/release/friction-bench
demo=${1:-demo}
if [ -e "$demo" ]; then
    n=2; while [ -e "$demo-$n" ]; do n=$((n + 1)); done
    demo=$demo-$n
fi
mkdir -p "$demo/calibration"

say() { printf '\n\033[1m%s\033[0m\n' "$*"; }
# The simulated bench's constants are not those of its description: they come from the seed, and calibration has to find them.
bench=(--mock bench-unknown --seed 7 --calibration "$demo/calibration/calibration.toml")
calibrate() { "$program" calibrate "$@" "${bench[@]}" --speed max --operator "the demonstration" --headless; }

say "The same signal into every input: gains, delays, noise  (friction-bench calibrate channels)"
calibrate channels
say "The pickup against a vibrometer  (friction-bench calibrate pickup)"
calibrate pickup
say "The plate's resonance, damping and force factor  (friction-bench calibrate plate)"
calibrate plate
say "The force sensor under known masses  (friction-bench calibrate force)"
calibrate force --normal-g 20,50,100,200 --lateral-g 20,50,100

say "Is everything there, alive, and as it was calibrated?  (friction-bench check)"
"$program" check "${bench[@]}" --protocol demo --study "$demo/study"

say "A session of one virtual participant, faster than real time  (friction-bench run)"
"$program" run "${bench[@]}" --speed max --headless --protocol demo --study "$demo/study" --participant sub-01 --consent-by "the demonstration"

say "From recordings to friction  (friction-bench analyze)"
"$program" analyze "$demo/study" --table --json "$demo/results.json" --figures "$demo/figures"

say "Look at"
printf '  %s\n' "$demo/calibration  what was measured of the bench, with its figures" "$demo/study        the recordings, the session's log" \
    "$demo/results.json every instance, both methods" "$demo/figures      the published figures, from these data"
printf '\nThe same in a terminal, in real time:\n  %s run --mock --protocol demo --study %s/study --participant sub-02 --consent-by ME\n' "$program" "$demo"
