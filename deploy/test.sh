#!/usr/bin/env bash
# Installs what is missing, checks the format, builds, runs the tests. Safe to repeat. Not here: the browser (deploy/browser.sh) and
# everything that takes hours (deploy/nightly.sh).
# Usage: deploy/test.sh [--sanitize] [ctest options]
#   --sanitize   one build with the address and undefined-behaviour sanitizers instead of the plain one; counts and packages are left out
source "$(dirname "$0")/lib/common.sh"
source "$root/deploy/lib/checks.sh"

preset=dev without="browser|hidden_effects_long|lies_long"
if [ "${1:-}" = --sanitize ]; then
  shift
  preset=asan without="$without|statistics|hidden_effects|packaging|web"
fi

part "packages"
install_missing build test check web bench
part "format"
check_format
part "build (preset $preset: programs, tests, benchmarks, examples)"
configure_and_build $preset -DDRIFTWISE_BUILD_BENCHMARKS=ON
[ $preset = asan ] || build_web $preset
part "tests"
run_tests $preset -LE "$without" "$@" || die "tests failed: the list is above; one again: ctest --preset $preset -R NAME"
parts_summary
say "all tests passed; the build is in build/$preset"
