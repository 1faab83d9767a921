// How long a diagnosis takes: an axis and three axes of a thousand rows, and a weekend of a row per
// second with thirty channels. CPU seconds of one thread; the weekend's peak memory is the
// process's.

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "server/diagnosis/diagnose.h"
#include "server/formats/formula/formula.h"
#include "tests/hidden_effects/shapes/hidden_world.h"

namespace driftwise {
namespace {

diagnosis::Diagnosis diagnosed(const Dataset& data, const std::string& baseline) {
  diagnosis::DiagnoseOptions options;
  const auto formula = formats::Formula::parse(baseline)->expand(data);
  if (!formula) throw std::runtime_error(formula.error().message);
  options.baseline = *formula;
  auto found = diagnosis::diagnose(data, options);
  if (!found) throw std::runtime_error(found.error().message);
  return std::move(*found);
}

std::string names_in(const diagnosis::Diagnosis& found) {
  std::string names;
  for (const auto& one : found.findings)
    names += (names.empty() ? "" : ", ") + one.cause + " " + one.subject;
  return names.empty() ? "nothing" : names;
}

void run(benchmark::State& state, const Dataset& data, const std::string& baseline) {
  std::string names;
  for (auto _ : state) names = names_in(diagnosed(data, baseline));
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  state.SetLabel(names + ", peak " + std::to_string(used.ru_maxrss / 1024) + " MB");
}

void thousand_rows(benchmark::State& state, hidden::Robot robot, bool with_lag) {
  std::vector<hidden::Hidden> what;
  if (with_lag) what.push_back({"thermal_lag", 900, 150});
  const auto made = hidden::make({.robot = robot}, what, 11);
  run(state, made.data, made.baseline);
}

// A move to one of seventeen places every twelve seconds; 60 hours.
Dataset weekend() {
  constexpr std::size_t kRows = 216000;
  constexpr int kSensors = 20;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0, 1);
  std::vector<std::vector<double>> t(kSensors), tilt(3);
  std::vector<double> q, x, air, pressure, humidity, time_s, dwell_s;
  std::vector<double> slow(kSensors, 0);
  double place = 0, since = 0, lagged = 21, wander = 0;
  for (std::size_t i = 0; i < kRows; ++i) {
    const auto now = static_cast<double>(i);
    if (i % 12 == 0) {
      place = 0.5 * static_cast<double>(random() % 17) - 4;
      since = 0;
    }
    since += 1;
    for (std::size_t s = 0; s < kSensors; ++s) {
      slow[s] += 0.004 * normal(random) - slow[s] / 5000;
      const double true_degc = 21 + 0.4 * std::sin(now / 13750 + static_cast<double>(s)) + slow[s];
      t[s].push_back(true_degc + 0.0015 * normal(random));
      if (s == 4) lagged += (true_degc - lagged) / 1800;
    }
    for (auto& one : tilt) one.push_back(0.3 * normal(random));
    air.push_back(21 + 0.5 * std::sin(now / 9000) + 0.05 * normal(random));
    pressure.push_back(1013 + 6 * std::sin(now / 70000));
    humidity.push_back(45 + 5 * std::sin(now / 40000));
    wander += 0.8 * normal(random) - wander / 30;
    x.push_back(place + 1e-6 * normal(random));
    q.push_back(x.back() * 1.0003 + 1e-6 * (300 * (t[2].back() - 21) + 60 * (lagged - 21) + wander +
                                            4 * normal(random)));
    time_s.push_back(now);
    dwell_s.push_back(since);
  }
  Dataset data;
  data.rows = kRows;
  data.time_s = std::move(time_s);
  data.dwell_s = std::move(dwell_s);
  data.columns = {{{"q1", "mm"}, q}, {{"x", "mm"}, x}};
  for (std::size_t k = 0; k < tilt.size(); ++k)
    data.columns.push_back({{std::string("r") + "xyz"[k], "arcsec"}, tilt[k]});
  for (std::size_t s = 0; s < kSensors; ++s)
    data.columns.push_back(
        {{(s < 9 ? "t0" : "t") + std::to_string(s + 1), "degC"}, std::move(t[s])});
  data.columns.push_back({{"air", "degC"}, air});
  data.columns.push_back({{"pressure", "hPa"}, pressure});
  data.columns.push_back({{"humidity", "pct"}, humidity});
  return data;
}

void a_weekend(benchmark::State& state) { run(state, weekend(), "q1 ~ x + x^2 + T"); }

BENCHMARK_CAPTURE(thousand_rows, axis_nothing, hidden::Robot::linear_axis, false)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(thousand_rows, axis_lag, hidden::Robot::linear_axis, true)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(thousand_rows, micro_nano_nothing, hidden::Robot::micro_nano, false)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(thousand_rows, micro_nano_lag, hidden::Robot::micro_nano, true)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(a_weekend)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace driftwise

BENCHMARK_MAIN();
