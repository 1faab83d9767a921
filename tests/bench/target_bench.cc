// A target in process, as every reader computes it: board, snapshot, request. The model has the
// size of the linear axis's: four powers of x and ten temperatures. Goals: 300 ns without, 1 us
// with uncertainty.
//   taskset -c 1 build/release/bin/target_bench --benchmark_repetitions=7
//   --benchmark_report_aggregates_only

#include <benchmark/benchmark.h>

#include "server/compensation/snapshot_board.h"
#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/formats/target_line.h"
#include "tests/unit/compensation/models.h"

namespace driftwise::compensation {
namespace {

calibration::Model published_size() {
  calibration::Model model;
  calibration::OutputModel q1;
  q1.channel = {"q1", "mm"};
  q1.terms = {term({}), term({power("x")}), term({power("x", 2)}), term({power("x", 3)})};
  model.domain = {{{"x", "mm"}, -4, 4}};
  for (int i = 1; i <= 10; ++i) {
    const std::string name = (i < 10 ? "t0" : "t") + std::to_string(i);
    q1.terms.push_back({{effects::Power{name, 1}}});
    model.domain.push_back({{name, "degC"}, 20, 22});
  }
  const auto size = static_cast<Eigen::Index>(q1.terms.size());
  q1.coefficients = Eigen::VectorXd::LinSpaced(size, 0.1, 1.0);
  q1.covariance = Eigen::MatrixXd::Identity(size, size) * 1e-12;
  q1.accuracy.rmse = 8e-6;
  model.outputs = {q1};
  return model;
}

const SnapshotBoard& board() {
  static SnapshotBoard board;
  static const bool published = [] {
    auto builder = std::move(*SnapshotBuilder::create(published_size(), ModelId{1}, axis_cell()));
    builder.keep_model_datum();
    std::vector<ChannelValue> values;
    for (const auto& range : builder.model().domain)
      values.push_back({range.channel.name(), 0.5 * (range.min + range.max)});
    builder.observe(values, CellTime{1});
    return board.publish(builder.build(CellTime{1}));
  }();
  benchmark::DoNotOptimize(published);
  return board;
}

void target(benchmark::State& state, bool with_uncertainty) {
  TargetRequest request;
  request.with_uncertainty = with_uncertainty;
  double x = -4;
  for (auto _ : state) {
    request.set(Variable::x, x);
    const auto read = board().read();
    benchmark::DoNotOptimize(compute_target(*read, request));
    x = x < 4 ? x + 1e-3 : -4;
  }
}
BENCHMARK_CAPTURE(target, without_uncertainty, false);
BENCHMARK_CAPTURE(target, with_uncertainty, true);

// The text line without its socket: parse, compute, write.
void target_text(benchmark::State& state) {
  std::string out;
  for (auto _ : state) {
    out.clear();
    const auto request = *formats::parse_target_line("TARGET x_mm=1.234567 u=1");
    const auto read = board().read();
    formats::append_target_answer(out, *read, compute_target(*read, request), true);
    benchmark::DoNotOptimize(out.data());
  }
}
BENCHMARK(target_text);

// A rebuild, as the application does every few seconds: to see that it never disturbs anybody.
void rebuild(benchmark::State& state) {
  auto builder = std::move(*SnapshotBuilder::create(published_size(), ModelId{1}, axis_cell()));
  SnapshotBoard own;
  for (auto _ : state) benchmark::DoNotOptimize(own.publish(builder.build(CellTime{1})));
}
BENCHMARK(rebuild);

}  // namespace
}  // namespace driftwise::compensation

BENCHMARK_MAIN();
