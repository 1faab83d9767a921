#include "tests/hidden_effects/plants/plant_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "drivers/simulated/plant/file/make_plant.h"
#include "tests/statistics/micro_nano_case.h"
#include "tests/support/plant_campaign.h"

namespace driftwise::hidden {
namespace {

using simulated::TimeNs;

constexpr TimeNs kRunEpoch = 1'600'000'000'000'000'000;
constexpr double kSettle_s = 1, kReading_s = 0.5;
constexpr double kStarted_s = 0.3;  // after a command the axis is on its way
constexpr int kReadingsOfPoint = 4, kMostGroups = 10;
constexpr double kGate_nm = 5;      // of a group's standard deviation
constexpr double kGrain_hpa = 0.1;  // of a barometer
constexpr double kMicroNanoRate_hz = 4096;

TimeNs instant_of(double seconds) {
  return kRunEpoch + static_cast<TimeNs>(std::llround(seconds * 1e9));
}

std::string thermometer_name(std::size_t i) {
  std::array<char, 8> name{};
  std::snprintf(name.data(), name.size(), "t%02zu", i + 1);
  return name.data();
}

std::size_t first_hidden(const std::vector<std::string>& columns) {
  std::size_t at = 0;
  while (at < columns.size() && !columns[at].starts_with("hidden_")) ++at;
  return at;
}

void note_hidden(simulated::CellPlant& plant, TimeNs at, PlantRun& run) {
  const auto columns = plant.truth_columns();
  const std::size_t first = first_hidden(columns);
  if (first == columns.size()) return;
  const auto values = plant.truth_values(at);
  run.hidden_nm.resize(columns.size() - first);
  for (std::size_t i = first; i < columns.size(); ++i)
    run.hidden_nm[i - first].push_back(values[i]);
}

class AxisRunner {
 public:
  explicit AxisRunner(const PlantStart& start)
      : plant_(simulated::make_plant(
            testing_support::linear_axis_plant_file(DRIFTWISE_SOURCE_DIR),
            {.seed = start.seed, .overrides = start.overrides, .epoch_ns = kRunEpoch})) {
    plant_->set_instants_per_reading(4);
    auto& columns = run_.data.columns;
    columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
    for (std::size_t i = 0; i < 10; ++i) columns.push_back({{thermometer_name(i), "degC"}, {}});
    columns.push_back({{"air", "degC"}, {}});
    columns.push_back({{"pressure", "hPa"}, {}});
    plant_->start_reference(0, instant_of(0));
    now_s_ = 15;
    plant_->start_move(0, 0, instant_of(now_s_));
    now_s_ += 3;
    plant_->zero_length(0, instant_of(now_s_));
    zero_nm_ = plant_->truth(instant_of(now_s_)).end_effector_nm;
    run_.true_mm.resize(1);
    run_.zero_q_mm = {plant_->axis(0, instant_of(now_s_)).q_mm};
  }

  void visit(const TrajectoryPoint& point, std::int64_t run) {
    plant_->start_move(0, point.target.front(), instant_of(now_s_));
    now_s_ += kStarted_s;
    while (plant_->axis(0, instant_of(now_s_)).moving) now_s_ += 0.02;
    const double end_s = now_s_;
    now_s_ += kSettle_s + point.dwell_s.value_or(0);
    Group group = read_group();
    for (int again = 1; again < kMostGroups && group.std_nm > kGate_nm; ++again)
      group = read_group();
    auto& data = run_.data;
    const TimeNs middle = instant_of(group.middle_s);
    data.time_s.push_back(group.middle_s);
    data.dwell_s.push_back(group.middle_s - end_s);
    data.set.push_back(point.set);
    data.line.push_back(point.line);
    data.zero.push_back(point.zero ? 1 : 0);
    data.run.push_back(run);
    data.columns[0].values.push_back(group.q_mm);
    data.columns[1].values.push_back(group.x_nm * 1e-6);
    const auto& probes = plant_->parameters().thermometers;
    for (std::size_t i = 0; i < 10; ++i)
      data.columns[2 + i].values.push_back(testing_support::degc_from_ohm(
          plant_->probe_ohm(probes[i].input, instant_of(now_s_)), probes[i].certificate_r0_ohm,
          probes[i].a_per_k, probes[i].b_per_k2));
    const double hpa = plant_->truth(middle).pressure_hpa;
    data.columns[12].values.push_back(group.air_degc);
    data.columns[13].values.push_back(std::round(hpa / kGrain_hpa) * kGrain_hpa);
    run_.true_mm.front().push_back((group.true_nm - zero_nm_) * 1e-6);
    note_hidden(*plant_, middle, run_);
    ++data.rows;
  }
  PlantRun done() { return std::move(run_); }

 private:
  struct Group {
    double middle_s = 0, q_mm = 0, x_nm = 0, std_nm = 0, air_degc = 0, true_nm = 0;
  };

  Group read_group() {
    const int samples = static_cast<int>(kReading_s * plant_->sample_rate_hz());
    Group group;
    std::array<double, kReadingsOfPoint> x_nm{};
    group.middle_s = now_s_ + kReadingsOfPoint * kReading_s / 2;
    for (double& one_nm : x_nm) {
      const TimeNs middle = instant_of(now_s_ + kReading_s / 2);
      const auto length = plant_->measure_length(0, instant_of(now_s_), samples);
      one_nm = length.mean_nm;
      group.air_degc = length.air_degc;
      group.q_mm += plant_->axis(0, middle).q_mm / kReadingsOfPoint;
      group.x_nm += one_nm / kReadingsOfPoint;
      group.true_nm += plant_->truth(middle).end_effector_nm / kReadingsOfPoint;
      now_s_ += kReading_s;
    }
    double square_nm2 = 0;
    for (const double one_nm : x_nm) square_nm2 += (one_nm - group.x_nm) * (one_nm - group.x_nm);
    group.std_nm = std::sqrt(square_nm2 / (kReadingsOfPoint - 1));
    return group;
  }

  std::unique_ptr<simulated::LinearAxisPlant> plant_;
  PlantRun run_;
  double now_s_ = 0, zero_nm_ = 0;
};

class MicroNanoRunner {
 public:
  explicit MicroNanoRunner(const PlantStart& start)
      : cell_(statistics::micro_nano_cell()), session_(DRIFTWISE_SOURCE_DIR, options_of(start)) {
    session_.plant().set_instants_per_reading(1);
    out_.true_mm.resize(3);
    for (int axis = 0; axis < 3; ++axis)
      out_.zero_q_mm.push_back(session_.plant().axis(axis, instant_of(session_.now_s())).q_mm);
  }

  void visit(const TrajectoryPoint& point, std::int64_t run) {
    if (point.force_n && *point.force_n != force_n_) session_.load(force_n_ = *point.force_n);
    std::array<double, 3> q_mm{};
    std::copy_n(point.target.begin(), 3, q_mm.begin());
    auto row = session_.visit(q_mm, kSettle_s + point.dwell_s.value_or(0));
    const double end_s = row.time_s - row.dwell_s;
    for (int again = 1; again < kMostGroups && spread_nm(row) > kGate_nm; ++again)
      row = session_.read_again();
    row.dwell_s = row.time_s - end_s;
    row.calibration = point.set == PointSet::calibration;
    row.zero = point.zero;
    row.line = static_cast<int>(point.line);
    note_hidden(session_.plant(), instant_of(row.time_s), out_);
    for (std::size_t k = 0; k < 3; ++k) out_.true_mm[k].push_back(row.true_mm[k]);
    runs_.push_back(run);
    rows_.push_back(row);
  }

  PlantRun done() {
    out_.data = statistics::micro_nano_dataset(rows_, cell_);
    for (const auto& row : rows_) out_.data.dwell_s.push_back(row.dwell_s);
    out_.data.run = runs_;
    return std::move(out_);
  }

 private:
  // Coarse steps of what is slow, but groups of four readings, as the cell takes them.
  static testing_support::MicroNanoOptions options_of(const PlantStart& start) {
    testing_support::MicroNanoOptions options;
    options.seed = start.seed;
    options.overrides = start.overrides;
    options.overrides.insert(options.overrides.begin(), "plant.step_s=2.0");
    options.readings = kReadingsOfPoint;
    options.samples = static_cast<int>(kReading_s * kMicroNanoRate_hz);
    return options;
  }
  static double spread_nm(const testing_support::MicroNanoRow& row) {
    return *std::ranges::max_element(row.path_std_nm);
  }

  CellDescription cell_;
  testing_support::MicroNanoSession session_;
  PlantRun out_;
  std::vector<testing_support::MicroNanoRow> rows_;
  std::vector<std::int64_t> runs_;
  double force_n_ = 0;
};

}  // namespace

PlantRun run_on_axis(const PlantStart& start, const std::vector<Trajectory>& trajectories) {
  AxisRunner runner(start);
  for (std::size_t run = 0; run < trajectories.size(); ++run)
    for (const auto& point : trajectories[run].points)
      runner.visit(point, static_cast<std::int64_t>(run) + 1);
  return runner.done();
}

PlantRun run_on_micro_nano(const PlantStart& start, const std::vector<Trajectory>& trajectories) {
  MicroNanoRunner runner(start);
  for (std::size_t run = 0; run < trajectories.size(); ++run)
    for (const auto& point : trajectories[run].points)
      runner.visit(point, static_cast<std::int64_t>(run) + 1);
  return runner.done();
}

}  // namespace driftwise::hidden
