#!/usr/bin/env bash
# The demonstration behind `./dev demo`: preflight, a session of one virtual participant, results, figures.
set -euo pipefail
cd "$(dirname "$0")/.."
bench=${CARGO_TARGET_DIR:-target}/release/friction-bench
demo=${1:-demo}
if [ -e "$demo" ]; then
    n=2; while [ -e "$demo-$n" ]; do n=$((n + 1)); done
    demo=$demo-$n
fi
mkdir -p "$demo"

say() { printf '\n\033[1m%s\033[0m\n' "$*"; }
say "Is everything there and alive?  (friction-bench check)"
"$bench" check --mock

say "A session of one virtual participant, faster than real time  (friction-bench run)"
"$bench" run --mock --headless --speed max --protocol demo --study "$demo/study" --participant sub-01 --consent-by "the demonstration"

say "From recordings to friction  (friction-bench analyze)"
"$bench" analyze "$demo/study" --table --json "$demo/results.json" --figures "$demo/figures"

say "Look at"
printf '  %s\n' "$demo/study      the recordings, the session's log" "$demo/results.json   every instance, both methods" "$demo/figures    the published figures, from these data"
printf '\nThe same in a terminal, in real time:\n  %s run --mock --protocol demo --study %s/study --participant sub-02 --consent-by ME\n' "$bench" "$demo"
