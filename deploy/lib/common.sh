# Shared by deploy/*.sh: say what is done, install what is missing, build. Sourced, not run.

set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
started=$(date +%s)

say() { printf '\n== %s  (%d s)\n' "$*" "$(($(date +%s) - started))"; }

# part NAME: a titled part whose duration appears in the table of parts_summary. The part before it ends here.
part_names=() part_starts=()
part() { part_names+=("$1"); part_starts+=("$(date +%s)"); say "$1"; }
parts_summary() {
  local i end now; now=$(date +%s)
  printf '\n%-44s %8s\n' "part" "seconds"
  for i in "${!part_names[@]}"; do
    end=${part_starts[$((i + 1))]:-$now}
    printf '%-44s %8d\n' "${part_names[$i]}" "$((end - part_starts[i]))"
  done
  printf '%-44s %8d\n' "whole" "$((now - started))"
}
die() { printf '\nfailed: %s\n' "$*" >&2; exit 1; }

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; return; fi
  command -v sudo >/dev/null || die "packages are missing and this is not root: run it as root, or install sudo and try again"
  sudo "$@"
}

# install_missing build [test] [check] [web] [compare]: what deploy/packages.txt lists for these uses and dpkg does not have yet. A
# package whose command is there already counts as installed, wherever it came from: a Node of one's own stays.
install_missing() {
  command -v apt-get >/dev/null || die "this script installs Debian 12 packages and found no apt-get: install what deploy/packages.txt lists by hand"
  local missing=() name use command
  while read -r name use command _; do
    case "$name" in ''|'#'*) continue ;; esac
    [[ " $* " == *" $use "* ]] || continue
    [ -n "$command" ] && command -v "$command" >/dev/null && continue
    dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null | grep -qx installed || missing+=("$name")
  done < "$root/deploy/packages.txt"
  if [ ${#missing[@]} = 0 ]; then echo "all packages are there"; return; fi
  echo "installing: ${missing[*]}"
  local log; log=$(mktemp)
  as_root apt-get update -qq >"$log" 2>&1 || { cat "$log" >&2; die "apt-get update failed: is a Debian 12 package source configured and reachable?"; }
  # --no-remove: Boost 1.81 and Debian's Boost 1.74 development files exclude one another, and removing is not ours to decide.
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-remove --no-install-recommends "${missing[@]}" >"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    die "apt-get could not install them without removing something. Boost 1.74 (libboost-dev) and what needs it exclude libboost1.81-dev: remove it yourself, or use a fresh Debian 12"
  }
  rm -f "$log"
}

# configure_and_build PRESET [cmake -D options] -- [targets]: quiet while it works, the compiler's words when it fails.
configure_and_build() {
  local preset=$1; shift
  local options=()
  while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1"); shift; done
  [ $# -gt 0 ] && shift
  cd "$root"
  # From nothing, files compiled together cost a third; a folder that exists stays as its owner configured it.
  # Line tables are a twelfth of the compiler's time; who looks for a crash configures the preset by itself.
  # Each time: the preset's own flags would come back, and with them a build of everything.
  local cache=build/$preset/CMakeCache.txt
  if [ ! -f "$cache" ] || grep -q '^DRIFTWISE_UNITY_BUILD:BOOL=ON' "$cache"; then
    options+=(-DDRIFTWISE_UNITY_BUILD=ON)
    if [ "$preset" = dev ]; then options+=(-DCMAKE_CXX_FLAGS_DEBUG=-Og); fi
  fi
  cmake --preset "$preset" "${options[@]}" >"/tmp/driftwise-configure.$$" 2>&1 || {
    tail -n 30 "/tmp/driftwise-configure.$$" >&2
    die "cmake could not configure: the lines above say what is missing"
  }
  rm -f "/tmp/driftwise-configure.$$"
  local targets=()
  [ $# -gt 0 ] && targets=(--target "$@")
  if [ -t 1 ]; then
    cmake --build --preset "$preset" "${targets[@]}"
  else  # one line in twenty is enough for a log
    cmake --build --preset "$preset" "${targets[@]}" 2>&1 | awk '!/^\[[0-9]+\/[0-9]+\]/ || NR % 20 == 1 { print; fflush() }'
  fi || die "the build failed: the compiler's message is above"
}

# build_web PRESET: the GUI's page, clients/web/dist. Without Node or the npm registry the daemon serves no page; the rest works.
build_web() {
  if ! command -v node >/dev/null || ! command -v npm >/dev/null; then
    echo "the web GUI is not built: it needs Node 18 or later with npm (Debian: apt-get install nodejs npm)"
    return
  fi
  cmake --build "$root/build/$1" --target web || echo "the web GUI is not built: the message is above. Is an npm registry reachable? Everything else works without it"
}

# run_tests PRESET [ctest options]: a test that fails is run once more, alone and aloud: processes on a busy machine may meet a time limit.
run_tests() {
  local preset=$1; shift
  cd "$root"
  # ctest leaves the list of an earlier time where it ends before any test: that is no list of this time's failures.
  local failed=build/$preset/Testing/Temporary/LastTestsFailed.log
  rm -f "$failed"
  ctest --preset "$preset" -j "$(nproc)" --no-tests=error "$@" && return
  [ -s "$failed" ] || return 1
  say "some tests failed (above); those again, one at a time. One that passes only now is flaky: report it"
  ctest --preset "$preset" --rerun-failed -j 1
}
