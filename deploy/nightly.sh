#!/usr/bin/env bash
# Everything that must hold before a release and takes hours, part by part. A part that passed at this commit is not repeated: a run that
# was ended goes on where it was. Each part that passes writes its date, commit, duration and last lines to docs/evidence/nightly/PART.md.
# Usage: deploy/nightly.sh [PART...]   (no name: all; --list prints them; --again repeats parts that passed)
source "$(dirname "$0")/lib/common.sh"
source "$root/deploy/lib/checks.sh"

parts=(tests asan tsan fuzz tidy browser hidden_effects bench)
describe() {
  case $1 in
    tests) echo "the plain build's tests, as deploy/test.sh" ;;
    asan) echo "every suite under the address and undefined-behaviour sanitizers, counts left out" ;;
    tsan) echo "the rooms without gRPC under the thread sanitizer" ;;
    fuzz) echo "every fuzz target for FUZZ_SECONDS (300) seconds under address and undefined-behaviour sanitizers; corpus in out/nightly/corpus" ;;
    tidy) echo "clang-tidy over all files" ;;
    browser) echo "the page in Chromium before a real daemon" ;;
    hidden_effects) echo "the long counts of the diagnosis and the table of the lies of a device" ;;
    bench) echo "the benchmarks" ;;
    *) return 1 ;;
  esac
}

run_tests_part() { "$root/deploy/test.sh"; }
run_asan_part() { "$root/deploy/sanitize.sh" asan; }
run_tsan_part() { "$root/deploy/sanitize.sh" tsan; }
run_browser_part() { "$root/deploy/browser.sh"; }
run_bench_part() { "$root/deploy/bench.sh"; }
run_hidden_effects_part() {
  install_missing build test
  configure_and_build release -DDRIFTWISE_BUILD_TESTS=ON
  cd "$root" && ctest --preset release -L "hidden_effects_long|lies_long" --no-tests=error
}
run_tidy_part() {
  install_missing build test check
  configure_and_build dev -DDRIFTWISE_BUILD_BENCHMARKS=ON
  mapfile -t files < <(git -C "$root" ls-files '*.cc')
  tidy_files dev 1000000 "${files[@]}" && git -C "$root" rev-parse HEAD >"$root/docs/evidence/tidy_clean_at"
}
run_fuzz_part() {
  install_missing build test check
  configure_and_build fuzz
  local seconds=${FUZZ_SECONDS:-300} target name
  for target in "$root"/build/fuzz/bin/*_fuzz; do
    name=$(basename "$target")
    mkdir -p "$root/out/nightly/corpus/$name"
    local seeds=(); [ -d "$root/tests/fuzz/corpus/${name%_fuzz}" ] && seeds=("$root/tests/fuzz/corpus/${name%_fuzz}")
    # 10 s for one input and 2 GB are far beyond what any parser may take.
    "$target" -max_total_time="$seconds" -max_len=65536 -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
      "$root/out/nightly/corpus/$name" "${seeds[@]}" >"$root/out/nightly/$name.log" 2>&1 ||
      { tail -n 40 "$root/out/nightly/$name.log"; die "$name failed: the input stands in the log above"; }
    echo "$name $(sed -n 's/^stat::number_of_executed_units: *//p' "$root/out/nightly/$name.log") inputs"
  done
}

again=no chosen=()
for word in "$@"; do
  case $word in
    --list) for p in "${parts[@]}"; do printf '%-16s %s\n' "$p" "$(describe "$p")"; done; exit 0 ;;
    --again) again=yes ;;
    *) describe "$word" >/dev/null || die "no part '$word': deploy/nightly.sh --list prints them"; chosen+=("$word") ;;
  esac
done
[ ${#chosen[@]} -gt 0 ] || chosen=("${parts[@]}")

state=$root/out/nightly
mkdir -p "$state" "$root/docs/evidence/nightly"
commit=$(git -C "$root" rev-parse --short HEAD)
failed=()
for p in "${chosen[@]}"; do
  if [ $again = no ] && [ "$(cat "$state/$p.passed" 2>/dev/null)" = "$commit" ]; then echo "$p: passed at $commit before"; continue; fi
  part "$p: $(describe "$p")"
  begun=$(date +%s)
  if (run_"$p"_part) >"$state/$p.log" 2>&1; then
    echo "$commit" >"$state/$p.passed"
    {
      echo "# $p: $(describe "$p")"
      echo
      echo "Passed on $(date -u +%F) at $commit in $(($(date +%s) - begun)) s on $(nproc) cores of $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1). Command: \`deploy/nightly.sh $p\`."
      echo
      echo '```'
      grep -E 'tests passed|tests failed|inputs$|clang-tidy:|goal|median|ratio' "$state/$p.log" | tail -n 60 || true
      echo '```'
    } >"$root/docs/evidence/nightly/$p.md"
    echo "passed"
  else
    tail -n 15 "$state/$p.log"
    echo "FAILED: the whole log is $state/$p.log"
    failed+=("$p")
  fi
done
parts_summary
[ ${#failed[@]} = 0 ] || die "parts that failed: ${failed[*]}; again: deploy/nightly.sh ${failed[*]}"
