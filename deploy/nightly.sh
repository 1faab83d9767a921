#!/usr/bin/env bash
# Everything that must hold before a release and takes hours, part by part. A part that passed at this commit is not repeated: a run that
# was ended goes on where it was. Each part that passes writes its date, commit, duration and last lines to docs/evidence/nightly/PART.md.
# Usage: deploy/nightly.sh [PART...]   (no name: all; --list prints them; --again repeats parts that passed)
source "$(dirname "$0")/lib/common.sh"
source "$root/deploy/lib/checks.sh"

parts=(tests asan tsan fuzz faults sixty_hours upgrade time_to_end tidy browser hidden_effects sealed bench)
describe() {
  case $1 in
    tests) echo "the plain build's tests, as deploy/test.sh" ;;
    asan) echo "every suite under the address and undefined-behaviour sanitizers, counts left out" ;;
    tsan) echo "the rooms without gRPC under the thread sanitizer" ;;
    fuzz) echo "every fuzz target under address and undefined-behaviour sanitizers: FUZZ_RUNS (1000000) inputs of at most 64 KiB, FUZZ_LARGEST (1000) of the largest size its door allows; corpus in out/nightly/corpus" ;;
    faults) echo "the fault campaign by classes, with counts and intervals: docs/evidence/fault_campaign.md" ;;
    sixty_hours) echo "sixty hours of cell time at the highest speed: memory, files, the record's growth, a target's latency: docs/evidence/sixty_hours.md" ;;
    upgrade) echo "the package in a root of its own: installed, upgraded in the middle of a queue with a schema step, removed" ;;
    time_to_end) echo "how often the end of a run lies in the stated band: docs/evidence/time_to_end.md" ;;
    tidy) echo "clang-tidy over all files" ;;
    browser) echo "the page in Chromium before a real daemon" ;;
    hidden_effects) echo "the long counts of the diagnosis and the table of the lies of a device" ;;
    sealed) echo "25 sealed random effects of each robot, found on the wire or not: docs/evidence/sealed-ROBOT.md" ;;
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
  tidy_files dev 1000000 "${files[@]}" || return
  [[ $commit = *-changed-* ]] || git -C "$root" rev-parse HEAD >"$root/docs/evidence/tidy_clean_at"
}
# The largest input of a target, in bytes: what its door takes. Files that only people on the machine name have no limit of
# their own: 4 MiB stands for them.
largest_of() {
  case $1 in
    api_requests_fuzz | grpc_web_frame_fuzz) echo $((33 << 20)) ;;
    dataset_csv_fuzz | foreign_csv_fuzz) echo $((32 << 20)) ;;
    trajectory_csv_fuzz) echo $((8 << 20)) ;;
    cell_file_fuzz | plant_file_fuzz | model_json_fuzz | stored_diagnosis_fuzz | import_mapping_fuzz | certificate_fuzz) echo $((4 << 20)) ;;
    robot_file_fuzz) echo $((256 << 10)) ;;
    formula_fuzz) echo $((16 << 10)) ;;
    *) echo $((64 << 10)) ;;
  esac
}
# A target that passed at this commit with these counts is not repeated; what it found of new paths stays in its corpus.
run_fuzz_part() {
  install_missing build test check
  configure_and_build fuzz
  local runs=${FUZZ_RUNS:-1000000} largest=${FUZZ_LARGEST:-1000} target name failed=()
  mkdir -p "$root/out/nightly/fuzz"
  for target in "$root"/build/fuzz/bin/*_fuzz; do
    name=$(basename "$target")
    local passed="$root/out/nightly/fuzz/$name.passed" log="$root/out/nightly/fuzz/$name.log"
    if [ "$(cat "$passed" 2>/dev/null)" = "$commit $runs $largest" ]; then echo "$name $runs inputs and $largest of $(largest_of "$name") bytes: passed before"; continue; fi
    mkdir -p "$root/out/nightly/corpus/$name"
    local seeds=(); [ -d "$root/tests/fuzz/corpus/$name" ] && seeds=("$root/tests/fuzz/corpus/$name")
    # 10 s for one input and 2 GB are far beyond what any parser may take; a large one has a minute.
    if "$target" -runs="$runs" -max_len=65536 -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 -artifact_prefix="$root/out/nightly/fuzz/$name-" \
         "$root/out/nightly/corpus/$name" "${seeds[@]}" >"$log" 2>&1 &&
       python3 -B "$root/tests/fuzz/largest.py" "$target" "$(largest_of "$name")" "$largest" "${seeds[@]}" >>"$log" 2>&1; then
      echo "$commit $runs $largest" >"$passed"
      echo "$name $(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | head -n 1) inputs and $largest of $(largest_of "$name") bytes"
    else
      tail -n 40 "$log"; failed+=("$name")
    fi
  done
  [ ${#failed[@]} = 0 ] || die "${failed[*]} failed: the inputs stand in out/nightly/fuzz"
}
run_faults_part() {
  install_missing build test
  configure_and_build release -DDRIFTWISE_BUILD_TESTS=ON
  python3 -B "$root/tests/faults/campaign/campaign.py" "$root/build/release/bin" "$root" --out "$root/out/nightly/faults" --table "$root/docs/evidence/fault_campaign.md"
}
run_sixty_hours_part() {
  install_missing build test
  configure_and_build release -DDRIFTWISE_BUILD_TESTS=ON
  python3 -B "$root/tests/faults/campaign/sixty_hours.py" "$root/build/release/bin" "$root" --table "$root/docs/evidence/sixty_hours.md"
}
run_sealed_part() {
  install_missing build test
  configure_and_build release -DDRIFTWISE_BUILD_TESTS=ON
  local robot missed=()
  for robot in linear-axis micro-nano; do
    python3 -B "$root/tests/hidden_effects/sealed/sealed.py" "$root/build/release/bin" "$root" --robot $robot --out "$root/out/nightly/sealed" \
      --table "$root/docs/evidence/sealed-$robot.md" || missed+=("$robot")
  done
  [ ${#missed[@]} = 0 ] || die "less than 85 % found: ${missed[*]}"
}
run_time_to_end_part() {
  install_missing build test
  configure_and_build release -DDRIFTWISE_BUILD_TESTS=ON
  "$root/build/release/bin/time_to_end"
}
run_upgrade_part() {
  "$root/deploy/package.sh"
  # The second build has a step of the schema that no release has; its folder is its own.
  cd "$root" && cmake --preset release -B build/upgrade -DDRIFTWISE_BUILD_TESTS=OFF -DDRIFTWISE_UNITY_BUILD=ON -DDRIFTWISE_TEST_SCHEMA_STEP=ON
  cmake --build "$root/build/upgrade"
  cmake --build "$root/build/upgrade" --target web || true
  python3 -B "$root/tests/integration/packaging/upgrade.py" "$root/build/release" "$root/build/upgrade"
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
# What differs from the commit is part of the name: else a part would have "passed" at sources that it never saw.
changed=$(git -C "$root" diff HEAD -- . ':!docs/evidence' | sha256sum | cut -c1-8)
git -C "$root" diff --quiet HEAD -- . ':!docs/evidence' || commit+=-changed-$changed
failed=()
for p in "${chosen[@]}"; do
  if [ $again = no ] && [ "$(cat "$state/$p.passed" 2>/dev/null)" = "$commit" ]; then echo "$p: passed at $commit before"; continue; fi
  part "$p: $(describe "$p")"
  begun=$(date +%s)
  # Not as a condition: there bash goes on after a command that failed, and a part would pass with the work of an earlier build.
  set +e
  (set -e; run_"$p"_part) >"$state/$p.log" 2>&1
  result=$?
  set -e
  if [ $result = 0 ]; then
    echo "$commit" >"$state/$p.passed"
    {
      echo "# $p: $(describe "$p")"
      echo
      echo "Passed on $(date -u +%F) at $commit in $(($(date +%s) - begun)) s on $(nproc) cores of $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1). Command: \`deploy/nightly.sh $p\`."
      echo
      echo '```'
      grep -E 'tests passed|tests failed|inputs|clang-tidy:|goal|median|ratio|^ok:|trials|^\| ' "$state/$p.log" | tail -n 60 || true
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
