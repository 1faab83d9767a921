#!/usr/bin/env bash
# Builds the benchmarks of tests/bench and prints the figures of the README: ratios of two things measured in one run, pinned to one core.
# Usage: deploy/bench.sh
source "$(dirname "$0")/lib/common.sh"

say "packages"
install_missing build test bench
say "build (preset release)"
configure_and_build release -DDRIFTWISE_BUILD_TESTS=ON -DDRIFTWISE_BUILD_BENCHMARKS=ON -- \
  engine_bench store_bench target_bench target_line_bench joint_target_bench rpc_bench regression_bench fit_floor_bench csv_bench driftwise \
  driftwised driftwise-cellsim
bin=$root/build/release/bin
scratch=$root/out/bench
rm -rf "$scratch"; mkdir -p "$scratch"
core=$(($(nproc) - 1))
run() { echo "\$ $1"; shift; taskset -c "$core" "$@"; }

say "machine: $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores; pinned to core $core"
say "engine and store per group of readings, in bare durable commits (goal 2.5)"
run engine_bench "$bin/engine_bench" "$scratch"
say "store alone, and the recorder's file growth"
run store_bench "$bin/store_bench" "$scratch" 1
say "a target in process (goal 300 ns, with uncertainty 1 us; three axes, 30 terms: 300 ns, with uncertainty 2 us)"
run target_bench "$bin/target_bench" --benchmark_repetitions=7 --benchmark_report_aggregates_only=true 2>/dev/null
say "unary gRPC target against an empty call (goal p99 1.2 x)"
run rpc_bench "$bin/rpc_bench" 3000
run rpc_bench_tls "$bin/rpc_bench" 3000 tls
say "text line against a bare echo (goal p99 1.3 x)"
run target_line_bench "$bin/target_line_bench" 3000
say "joint target of two robots over the text line against a single one (goal p99 1.3 x: line_p99_ratio)"
run joint_target_bench "$bin/joint_target_bench" 3000
say "regression (triangle, selection, solution)"
run regression_bench "$bin/regression_bench" --benchmark_repetitions=3 --benchmark_report_aggregates_only=true 2>/dev/null

say "a fit against OpenBLAS's SYRK, rows split over the threads (not pinned: both use every core)"
echo '$ fit_floor_bench'; "$bin/fit_floor_bench" 7
say "a fit of 1e6 rows x 40 columns against fast_float on the same mapped file (goal 2 x)"
echo '$ csv_bench'; "$bin/csv_bench" make "$scratch/large.csv" 1000000 40; "$bin/csv_bench" "$scratch/large.csv" 5
echo '$ driftwise fit (whole process), csv_bench parse (whole process)'
for command in "$bin/driftwise fit $scratch/large.csv --model" "$bin/csv_bench parse $scratch/large.csv"; do
  for _ in 1 2 3; do
    begun=$(date +%s%N)
    if [[ $command == *--model ]]; then $command "q1 ~ poly(x, 3) + T" >"$scratch/fit.txt"; else $command >/dev/null; fi
    echo "$(basename "${command%% *}"): $((($(date +%s%N) - begun) / 1000000)) ms"
  done
done
rm -f "$scratch/large.csv"

say "the daemon: ready after, memory when idle (goals 100 ms, 40 MB)"
cell=$root/deploy/cells/linear-axis
cellsim= daemon=
trap 'kill -TERM $daemon $cellsim 2>/dev/null || true' EXIT
"$bin/driftwise-cellsim" --plant "$cell/plant.toml" --cell "$cell/cell.toml" --instantiate "$scratch/cell" --speed 1 >"$scratch/cellsim.out" & cellsim=$!
for _ in $(seq 200); do grep -qs READY "$scratch/cellsim.out" && break; sleep 0.05; done
begun=$(date +%s%N)
"$bin/driftwised" --cell "$scratch/cell/cell.toml" >"$scratch/driftwised.out" 2>&1 & daemon=$!
while [ ! -s "$scratch/cell/driftwised.json" ]; do kill -0 "$daemon" || die "driftwised ended: see $scratch/driftwised.out"; sleep 0.002; done
echo "ready after $((($(date +%s%N) - begun) / 1000000)) ms (polled every 2 ms by a shell)"
sleep 10
echo "resident after 10 s of recording: $(sed -n 's/^VmRSS: *//p' "/proc/$daemon/status")"
