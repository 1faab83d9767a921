#!/usr/bin/env bash
# The published study from nothing to proof: installs what is missing, builds, lets the daemon measure the simulated robot over its real
# protocols, fits, validates, serves compensated targets, and moves to new positions while the air drifts. Safe to repeat.
# Usage: deploy/demo.sh [linear-axis | micro-nano] [--speed CELL_SECONDS_PER_SECOND] [--seed N] [--no-build]
#   linear-axis   case A, one flexure axis under the air's drift (without a name: this one)
#   micro-nano    case B, a delta of three axes under heat and force
source "$(dirname "$0")/lib/common.sh"

robot=linear-axis speed= seed=1 build=yes
case "${1:-}" in linear-axis | micro-nano) robot=$1; shift ;; esac
while [ $# -gt 0 ]; do
  case "$1" in
    --speed) speed=${2:?--speed needs a number}; shift 2 ;;
    --seed) seed=${2:?--seed needs a number}; shift 2 ;;
    --no-build) build=no; shift ;;
    *) die "unknown option '$1'; there are the robots linear-axis and micro-nano, first, then --speed, --seed and --no-build" ;;
  esac
done
source "$root/deploy/lib/cell.sh"
source "$root/deploy/lib/$robot.sh"
speed=${speed:-$default_speed}

if [ $build = yes ]; then
  say "packages"
  install_missing build
  say "build (preset release)"
  configure_and_build release -DDRIFTWISE_BUILD_TESTS=OFF
  build_web release
fi
need_programs
demo
