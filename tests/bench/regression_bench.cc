// Fit speed at the sizes of the published cases. Measured: triangle, selection, solution; data
// preparation and held-out blocks apart. Against the floor of OpenBLAS: fit_floor_bench.
//   regression_bench --benchmark_repetitions=7

#include <benchmark/benchmark.h>

#include <Eigen/Core>

#include "server/calibration/design/design.h"
#include "server/calibration/linear/row_reduction.h"
#include "server/calibration/linear/solution.h"
#include "server/calibration/selection/stepwise.h"
#include "tests/bench/fit_problems.h"

namespace {

using namespace driftwise;
using namespace driftwise::calibration;
using namespace driftwise::bench;

void fit_prepared(benchmark::State& state, const Problem& problem) {
  const auto design = make_design(problem.data, problem.options);
  for (auto _ : state) {
    const Triangle triangle =
        RowReduction(*design, {0, design->row_count()}, Solver::automatic, {}).all();
    for (Eigen::Index o = 0; o < static_cast<Eigen::Index>(design->outputs.size()); ++o) {
      const Selection selection = select(triangle, design->basis, design->always, o, {});
      benchmark::DoNotOptimize(solve(triangle, design->basis, selection.set.order(), o));
    }
  }
}

void qr_alone(benchmark::State& state, const Problem& problem) {
  const auto design = make_design(problem.data, problem.options);
  for (auto _ : state)
    benchmark::DoNotOptimize(RowReduction(*design, {0, design->row_count()}, Solver::qr, {}).all());
}

// The floor: X'X with Eigen's own product, one thread.
void gram_floor(benchmark::State& state, const Problem& problem) {
  const auto design = make_design(problem.data, problem.options);
  const Eigen::MatrixXd matrix = design->block(0, design->row_count());
  Eigen::MatrixXd gram(matrix.cols(), matrix.cols());
  for (auto _ : state) {
    gram.setZero();
    gram.selfadjointView<Eigen::Lower>().rankUpdate(matrix.transpose());
    benchmark::DoNotOptimize(gram.data());
  }
}

void whole_fit(benchmark::State& state, const Problem& problem) {
  for (auto _ : state) benchmark::DoNotOptimize(fit(problem.data, problem.options));
}

BENCHMARK_CAPTURE(fit_prepared, 560x12, case_a())->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(qr_alone, 560x12, case_a())->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(gram_floor, 560x12, case_a())->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(whole_fit, 560x12, case_a())->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(fit_prepared, 756x29x3, case_b())->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(qr_alone, 756x29x3, case_b())->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(gram_floor, 756x29x3, case_b())->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(fit_prepared, 1e5x60, many_rows(100000, 60))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(gram_floor, 1e5x60, many_rows(100000, 60))->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
