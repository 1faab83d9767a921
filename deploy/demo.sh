#!/usr/bin/env bash
# The published study from nothing to proof: installs what is missing, builds, lets the daemon measure the simulated robot over its real
# protocols, fits, validates, serves compensated targets, and moves to new positions while the air drifts. Safe to repeat.
# Usage: deploy/demo.sh [linear-axis | micro-nano | minangle | indentation | delta-cube-2] [--speed CELL_SECONDS_PER_SECOND] [--seed N]
#                       [--hide-seed N | --no-hide] [--by-geometry] [--substrates N] [--no-build] [--keep]
#   linear-axis   case A, one flexure axis under the air's drift (without a name: this one)
#   micro-nano    case B, a delta of three axes under heat and force
#   minangle      case C.1, two tilts and a height, measured in set-ups: touch probe, inclinometer, autocollimators, interferometers
#   indentation   case C.2, the Micro-Nano with an indenter touches a substrate on the MinAngle: both calibrated, a serving plan,
#                 alignment, indents, table 8.1; --by-geometry: without models, by raw motor coordinates of the drawing
#   delta-cube-2  chapter 2, the predecessors: three sessions in a box, joined; model-based and model-free side by side
#   --substrates  indentation: that many substrates, tilted by random up to 0.5 degrees, are aligned by the plan instead of one indented
#   --hide-seed   what the last chapter hides is drawn with it: the day's date (20261231) unless given; --no-hide leaves the chapter out
#   --keep        the cell, the daemon and its page run on until Enter or Ctrl-C
source "$(dirname "$0")/lib/common.sh"

robot=linear-axis speed= seed=1 by=plan substrates=0 hide_seed=$(date +%Y%m%d) build=yes keep=no
case "${1:-}" in
  linear-axis | micro-nano) robot=$1; shift ;;
  minangle | min-angle) robot=min-angle; shift ;;
  indentation | two-robots) robot=two-robots; shift ;;
  delta-cube-2) robot=delta-cube-2; shift ;;
esac
while [ $# -gt 0 ]; do
  case "$1" in
    --speed) speed=${2:?--speed needs a number}; shift 2 ;;
    --seed) seed=${2:?--seed needs a number}; shift 2 ;;
    --hide-seed) hide_seed=${2:?--hide-seed needs a number}; shift 2 ;;
    --no-hide) hide_seed=; shift ;;
    --by-geometry) by=geometry; shift ;;
    --substrates) substrates=${2:?--substrates needs a number}; shift 2 ;;
    --no-build) build=no; shift ;;
    --keep) keep=yes; shift ;;
    *) die "unknown option '$1'; there are the robots linear-axis, micro-nano, minangle, indentation and delta-cube-2, first, then --speed, --seed, --hide-seed, --no-hide, --by-geometry, --substrates, --no-build and --keep" ;;
  esac
done
source "$root/deploy/lib/cell.sh"
source "$root/deploy/lib/hidden.sh"
source "$root/deploy/lib/$robot.sh"
speed=${speed:-$default_speed}

if [ $build = yes ]; then
  part "packages"
  install_missing build web
  part "build: daemon, command line, simulated cell, report (preset release)"
  configure_and_build release -DDRIFTWISE_BUILD_TESTS=OFF -- driftwised driftwise driftwise-cellsim driftwise-demo-report
  part "build: the page"
  build_web release
fi
need_programs
part "the demo"
demo
if [ -n "$hide_seed" ] && [ $robot = linear-axis ]; then
  part "hide it yourself"
  hidden_chapter "$hide_seed"
fi
parts_summary
if [ $keep = yes ]; then keep_running; else next_words; fi
