#!/usr/bin/env bash
# The suites under the address and undefined-behaviour sanitizers, then, without gRPC, under the thread sanitizer. Each is a build
# of its own: together they take about twice as long as deploy/test.sh. Safe to repeat. Usage: deploy/sanitize.sh [asan|tsan]
source "$(dirname "$0")/lib/common.sh"

say "packages"
install_missing build test check
if [ "${1:-asan}" = asan ]; then
  say "address and undefined-behaviour sanitizers"
  configure_and_build asan
  # Claims about rates say nothing about memory and take minutes there; nor do packages and pages of Node.
  run_tests asan -LE "statistics|hidden_effects|packaging|web|browser"
fi
if [ "${1:-tsan}" = tsan ]; then
  say "thread sanitizer, the rooms without gRPC"
  configure_and_build tsan
  run_tests tsan -LE "statistics|hidden_effects|numbers|packaging|web|browser"  # nor does one thread of least squares say anything about races
fi
say "done"
