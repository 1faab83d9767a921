#!/usr/bin/env bash
# Installs what is missing, builds, runs the tests but those in a browser (deploy/browser.sh)
# and the long part of the hidden effects (ctest --preset dev -L hidden_effects_long). Safe to repeat. Usage: deploy/test.sh [ctest options]
source "$(dirname "$0")/lib/common.sh"

say "packages"
install_missing build test web
say "build (preset dev)"
configure_and_build dev
build_web dev
say "tests"
run_tests dev -LE "browser|hidden_effects_long" "$@" || die "tests failed: the list is above; one again: ctest --preset dev -R NAME"
say "all tests passed; the build is in build/dev"
