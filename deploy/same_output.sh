#!/usr/bin/env bash
# Output of two builds compared byte by byte: what a change of structure alone must leave as it was. Nothing is built.
# Usage: deploy/same_output.sh BEFORE AFTER [--keep FOLDER]
#   BEFORE, AFTER   two folders with driftwise, driftwised, driftwise-demo-report, foreign_generator and coverage: build/dev/bin
#   --keep FOLDER   where the outputs of both sides stay (else out/same_output); it is emptied first
# Exit code 0: nothing differs; 1: something does, the first difference is printed; 2: usage.
#
# Masked, because they differ between two runs of one program: fit_us (time of a fit), model_id (number of a stored model),
# the milliseconds of a fit in the demo's table, and the daemon's version and commit. Paths and everything else count.
source "$(dirname "$0")/lib/common.sh"

usage() { sed -n '2,6s/^# //p' "$0" >&2; exit 2; }
keep=$root/out/same_output sides=()
while [ $# -gt 0 ]; do
  case "$1" in
    --keep) keep=${2:?--keep needs a folder}; shift 2 ;;
    -*) usage ;;
    *) sides+=("$1"); shift ;;
  esac
done
[ ${#sides[@]} = 2 ] || usage
before=$(cd "${sides[0]}" && pwd) after=$(cd "${sides[1]}" && pwd)
for program in driftwise driftwised driftwise-demo-report foreign_generator coverage; do
  for side in "$before" "$after"; do [ -x "$side/$program" ] || die "$side/$program is not there"; done
done
rm -rf "$keep"; mkdir -p "$keep/sets"; keep=$(cd "$keep" && pwd)
source "$root/deploy/lib/same_output_parts.sh"

say "data sets, by the generator of $before"
make_sets
[ "$(wc -l <"$keep/sets/list")" = 60 ] || die "60 data sets were expected, see $keep/sets/list"

say "both sides at once"
side_outputs "$before" "$keep/before" 1 & pid_before=$!
side_outputs "$after" "$keep/after" 2 & pid_after=$!
trap 'kill -TERM $pid_before $pid_after 2>/dev/null || true' INT TERM
wait $pid_before || die "the programs of $before did not get through: see $keep/before"
wait $pid_after || die "the programs of $after did not get through: see $keep/after"

say "compared"
compare_sides
