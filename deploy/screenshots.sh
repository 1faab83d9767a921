#!/usr/bin/env bash
# Pictures of every view of the web page, light and dark, into docs/screenshots: a simulated Micro-Nano measures a campaign, which
# is fitted and diagnosed, and the page is photographed in Chromium on the way. Safe to repeat; takes some minutes.
# Usage: deploy/screenshots.sh [--no-build] [--out FOLDER] [--speed CELL_SECONDS_PER_SECOND]
# DRIFTWISE_BUILD names the preset whose programs are used (release).
source "$(dirname "$0")/lib/common.sh"

build=yes preset=${DRIFTWISE_BUILD:-release} options=()
while [ $# -gt 0 ]; do
  case "$1" in
    --no-build) build=no; shift ;;
    --out | --speed) options+=("$1" "${2:?$1 needs a value}"); shift 2 ;;
    *) die "unknown option '$1'; there are --no-build, --out and --speed" ;;
  esac
done
web=$root/clients/web

if [ $build = yes ]; then
  say "packages"
  install_missing build web browser
  say "build (preset $preset)"
  configure_and_build "$preset" -DDRIFTWISE_BUILD_TESTS=OFF
  say "the page"
  (cd "$web" && npm ci --ignore-scripts --silent && npm run --silent build)
fi
[ -f "$web/dist/index.html" ] || die "$web/dist is not there: run it without --no-build"

say "campaign and pictures"
DRIFTWISE_BIN_DIR=$root/build/$preset/bin node "$web/scripts/screenshots.mjs" "${options[@]}"
say "done"
