#!/usr/bin/env bash
# Pictures of every view of the web page, light and dark, and of most on a phone, into docs/screenshots: a simulated Micro-Nano in
# which a play is hidden measures a campaign, which is fitted, diagnosed and improved, and the page is photographed in Chromium
# on the way; plans and indentation are those of deploy/demo.sh indentation. Safe to repeat; takes about ten minutes.
# Usage: deploy/screenshots.sh [--no-build] [--out FOLDER] [--speed CELL_SECONDS_PER_SECOND] [--only-robots]
#   --only-robots   the pictures of the two robots alone
# DRIFTWISE_BUILD names the preset whose programs are used (release).
source "$(dirname "$0")/lib/common.sh"

build=yes preset=${DRIFTWISE_BUILD:-release} options=() out=() story=yes
while [ $# -gt 0 ]; do
  case "$1" in
    --no-build) build=no; shift ;;
    --only-robots) story=no; shift ;;
    --speed) options+=("$1" "${2:?$1 needs a value}"); shift 2 ;;
    --out) out=(--out "$(realpath -m "${2:?$1 needs a value}")"); shift 2 ;;
    *) die "unknown option '$1'; there are --no-build, --out, --speed and --only-robots" ;;
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

export DRIFTWISE_BIN_DIR=$root/build/$preset/bin
photograph() { node "$web/scripts/screenshots.mjs" "${out[@]}" "$@"; }
status=0
if [ $story = yes ]; then
  say "campaign and pictures"
  photograph "${options[@]}" || status=$?
fi

say "two robots: calibration, serving plan, indentation"
log=$(mktemp) ready='The cell and its daemon run on.'
DRIFTWISE_BUILD=$preset "$root/deploy/demo.sh" indentation --no-build --keep </dev/null >"$log" 2>&1 & robots=$!
trap 'kill -TERM $robots 2>/dev/null || true; wait $robots || true; rm -f "$log"' EXIT
until grep -q "$ready" "$log"; do
  kill -0 $robots 2>/dev/null || { tail -n 20 "$log" >&2; die "the demo of two robots ended early: its last lines are above"; }
  sleep 1
done
address=$(sed -n 's/.*"web": *"\([^"]*\)".*/\1/p' "$root/out/two-robots/driftwised.json")
photograph --url "$address" plans indentation || status=$?
[ $status = 0 ] || die "the page was not as it should be: the lines above say which picture and why"
say "done"
