#!/usr/bin/env bash
# The web page in a real Chromium before a real daemon and a simulated cell. Safe to repeat. Usage: deploy/browser.sh [ctest options]
source "$(dirname "$0")/lib/common.sh"

say "packages"
install_missing build test web browser
say "build (preset dev)"
configure_and_build dev
build_web dev
say "the page in Chromium"
cd "$root" && ctest --preset dev -L browser -j 1 --no-tests=error "$@" || die "a browser test failed: the list is above"
