#!/usr/bin/env bash
# Ten demos of one robot, one after the other, and the spread of their figures: deploy/lib/demo_spread.py. On a machine without other
# work: a loaded one stretches the campaign in cell time, and the room goes further meanwhile.
# Usage: deploy/lib/demo_spread.sh [linear-axis | micro-nano] [FIRST_SEED [COUNT]]    (linear-axis, 1, 10; of a built tree)
# A demo that is there is not run again: a stopped series continues. Printed output: out/spread/ROBOT.SEED.txt
source "$(dirname "$0")/common.sh"

robot=${1:-linear-axis} first=${2:-1} count=${3:-10}
[[ $robot == linear-axis || $robot == micro-nano ]] || die "found robot '$robot', expected linear-axis or micro-nano"
kept=$root/out/spread
mkdir -p "$kept"
texts=()
for seed in $(seq "$first" $((first + count - 1))); do
  text=$kept/$robot.$seed.txt
  texts+=("$text")
  [ -s "$text" ] && continue
  say "$robot, seed $seed, load $(cut -d' ' -f1-3 /proc/loadavg)"
  instance=spread-$robot-$seed "$root/deploy/demo.sh" "$robot" --no-build --no-hide --seed "$seed" >"$text.part" 2>"$text.log" ||
    die "the demo ended early: $text.part, $text.log"
  mv "$text.part" "$text"
done
"$root/deploy/lib/demo_spread.py" "${texts[@]}"
