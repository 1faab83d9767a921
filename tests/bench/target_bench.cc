// A target in process, as every reader computes it: board, snapshot, request. Two models: the size
// of the linear axis's, four powers of x and ten temperatures (goals: 300 ns without, 1 us with
// uncertainty), and the size of the three-axis robot's, three outputs of 30 terms each, poly(x, y,
// z, 3), force to the third power and seven temperatures (300 ns, 2 us).
//   taskset -c 1 build/release/bin/target_bench --benchmark_repetitions=7
//   --benchmark_report_aggregates_only

#include <benchmark/benchmark.h>

#include "server/compensation/snapshot_board.h"
#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/formats/export/target_line.h"
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

calibration::Model three_axes() {
  calibration::Model model;
  std::vector<effects::Term> terms;
  for (int i = 0; i <= 3; ++i)
    for (int j = 0; i + j <= 3; ++j)
      for (int k = 0; i + j + k <= 3; ++k) {
        effects::Term one;
        if (i > 0) one.factors.emplace_back(power("x", i));
        if (j > 0) one.factors.emplace_back(power("y", j));
        if (k > 0) one.factors.emplace_back(power("z", k));
        terms.push_back(std::move(one));
      }
  for (int k = 1; k <= 3; ++k) terms.push_back(term({power("force", k)}));
  for (const char* axis : {"x", "y", "z"}) model.domain.push_back({{axis, "mm"}, 0, 2.5});
  model.domain.push_back({{"force", "N"}, 0, 3.842});
  for (int k = 4; k <= 10; ++k) {
    const std::string name = (k < 10 ? "t0" : "t") + std::to_string(k);
    terms.push_back({{effects::Power{name, 1}}});
    model.domain.push_back({{name, "degC"}, 20, 22});
  }
  for (int o = 1; o <= 3; ++o) {
    calibration::OutputModel output;
    output.channel = {"q" + std::to_string(o), "mm"};
    output.terms = terms;
    const auto size = static_cast<Eigen::Index>(terms.size());
    output.coefficients = Eigen::VectorXd::LinSpaced(size, 0.1, 1.0);
    output.covariance = Eigen::MatrixXd::Identity(size, size) * 1e-12;
    output.accuracy.rmse = 8e-6;
    model.outputs.push_back(std::move(output));
  }
  return model;
}

CellDescription three_axis_cell() {
  CellDescription cell = axis_cell();
  auto axis = cell.devices[0].axes()[0];
  for (const char* name : {"q2", "q3"}) {
    axis.channel.symbol = name;
    cell.devices[0].become<MotionSettings>().axes.push_back(axis);
  }
  return cell;
}

void serve(SnapshotBoard& board, const calibration::Model& model, const CellDescription& cell) {
  auto builder = std::move(*SnapshotBuilder::create(model, ModelId{1}, cell));
  builder.keep_model_datum();
  std::vector<ChannelValue> values;
  for (const auto& range : builder.model().domain)
    values.push_back({range.channel.name(), 0.5 * (range.min + range.max)});
  builder.observe(values, CellTime{1});
  benchmark::DoNotOptimize(board.publish(builder.build(CellTime{1})));
}

const SnapshotBoard& board() {
  static SnapshotBoard board;
  static const bool published = (serve(board, published_size(), axis_cell()), true);
  benchmark::DoNotOptimize(published);
  return board;
}

const SnapshotBoard& three_axis_board() {
  static SnapshotBoard board;
  static const bool published = (serve(board, three_axes(), three_axis_cell()), true);
  benchmark::DoNotOptimize(published);
  return board;
}

TargetRequest request_at(double x, bool with_uncertainty) {
  TargetRequest request;
  request.with_uncertainty = with_uncertainty;
  for (const Variable variable : {Variable::x, Variable::y, Variable::z, Variable::force})
    request.set(variable, x);
  return request;
}

void target(benchmark::State& state, const SnapshotBoard& board, bool with_uncertainty) {
  double x = 0;
  for (auto _ : state) {
    const auto read = board.read();
    const Target answer = compute_target(*read, request_at(x, with_uncertainty));
    if (answer.refusal != Refusal::none) return state.SkipWithError("refused");
    benchmark::DoNotOptimize(&answer);
    x = x < 2.5 ? x + 1e-3 : 0;
  }
}
BENCHMARK_CAPTURE(target, without_uncertainty, board(), false);
BENCHMARK_CAPTURE(target, with_uncertainty, board(), true);
BENCHMARK_CAPTURE(target, three_axes_without_uncertainty, three_axis_board(), false);
BENCHMARK_CAPTURE(target, three_axes_with_uncertainty, three_axis_board(), true);

// Every line of the budget of all three outputs, as `driftwise target --budget` asks for it.
void budget(benchmark::State& state) {
  double x = 0;
  for (auto _ : state) {
    const auto read = three_axis_board().read();
    for (std::size_t output = 0; output < 3; ++output)
      benchmark::DoNotOptimize(compute_budget(*read, request_at(x, true), output));
    x = x < 2.5 ? x + 1e-3 : 0;
  }
}
BENCHMARK(budget);

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
