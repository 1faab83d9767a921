#!/bin/bash
# Builds the Debian package: programs, web pages, man pages, completions, the systemd unit. Result: build/release/*.deb
. "$(dirname "$0")/lib/common.sh"

say "packages"
install_missing build test
say "building the programs"
configure_and_build release -DDRIFTWISE_BUILD_TESTS=OFF
build_web release
say "packaging"
(cd build/release && cpack -G DEB)
ls -l build/release/*.deb
