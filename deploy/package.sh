#!/bin/bash
# Builds the Debian package: programs, web pages, man pages, completions, the systemd unit. Result: build/release/*.deb
. "$(dirname "$0")/lib/common.sh"

say "packages"
install_missing build test web
say "building the programs"
configure_and_build release -DDRIFTWISE_BUILD_TESTS=OFF
rm -rf clients/web/dist  # of another commit
build_web release
[ -f clients/web/dist/index.html ] || die "no package without the web pages: the message above says what they lack"
say "packaging"
(cd build/release && cpack -G DEB)
ls -l build/release/*.deb
