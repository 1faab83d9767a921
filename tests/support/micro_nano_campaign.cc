#include "tests/support/micro_nano_campaign.h"

#include <cmath>

#include "drivers/simulated/plant/file/make_plant.h"
#include "tests/support/plant_campaign.h"

namespace driftwise::testing_support {
namespace {

using simulated::TimeNs;
using Three = std::array<double, 3>;

constexpr TimeNs kCampaignEpoch = 1'600'000'000'000'000'000;
constexpr double kNmInMm = 1e6;
constexpr int kAxes = 3;

TimeNs instant(double seconds) {
  return kCampaignEpoch + static_cast<TimeNs>(std::llround(seconds * 1e9));
}

std::size_t at(int index) { return static_cast<std::size_t>(index); }

MicroNanoOptions prepared(MicroNanoOptions options) {
  if (options.coarse) {
    options.overrides.insert(options.overrides.begin(), "plant.step_s=2.0");
    options.samples *= options.readings;
    options.readings = 1;
  }
  return options;
}

}  // namespace

MicroNanoSession::MicroNanoSession(const std::string& source_dir, MicroNanoOptions options)
    : options_(prepared(std::move(options))),
      plant_(simulated::make_micro_nano_plant(
          source_dir + "/deploy/cells/micro-nano/plant.toml",
          {.seed = options_.seed, .overrides = options_.overrides, .epoch_ns = kCampaignEpoch})) {
  if (options_.coarse) plant_->set_instants_per_reading(1);
  for (int axis = 0; axis < kAxes; ++axis) plant_->start_reference(axis, instant(0));
  now_s_ = 15;
  for (int axis = 0; axis < kAxes; ++axis) plant_->start_move(axis, 0, instant(now_s_));
  now_s_ += 5;
  zero_instruments();
}

void MicroNanoSession::zero_instruments() {
  for (int beam = 0; beam < kAxes; ++beam) plant_->zero_length(beam, instant(now_s_));
  true_zero_ = plant_->truth(instant(now_s_));
  zero_r_arcsec_ = {};
  zero_r_arcsec_ = angles_arcsec(now_s_);
  now_s_ += 3;
}

void MicroNanoSession::wait(double seconds) { now_s_ += seconds; }

MicroNanoRow MicroNanoSession::zero() {
  const MicroNanoRow before = visit({0, 0, 0});
  zero_instruments();
  return before;
}

// Both devices over two seconds. Angles are relative to the zero pose, as the lengths are.
Three MicroNanoSession::angles_arcsec(double start_s) {
  constexpr double kAverage_s = 2;
  const TimeNs end = instant(start_s + kAverage_s);
  const auto along_x = plant_->measure_angle(0, kAverage_s, end);
  const auto along_y = plant_->measure_angle(1, kAverage_s, end);
  Three r{along_y.y_arcsec, along_x.y_arcsec, along_x.z_arcsec};
  for (std::size_t k = 0; k < 3; ++k) r[k] -= zero_r_arcsec_[k];
  return r;
}

MicroNanoRow MicroNanoSession::read(double start_s) {
  MicroNanoRow row;
  const double length_s = options_.samples / plant_->sample_rate_hz();
  const double share = 1.0 / options_.readings;
  std::vector<Three> shown_nm;
  for (int k = 0; k < options_.readings; ++k) {
    const TimeNs begin = instant(start_s + k * length_s);
    const TimeNs middle = instant(start_s + (k + 0.5) * length_s);
    for (int axis = 0; axis < kAxes; ++axis) {
      row.q_mm[at(axis)] += share * plant_->axis(axis, middle).q_mm;
    }
    auto& nm = shown_nm.emplace_back();
    for (int beam = 0; beam < kAxes; ++beam) {
      const auto reading = plant_->measure_length(beam, begin, options_.samples);
      nm[at(beam)] = reading.mean_nm;
      row.air_degc[at(beam)] = reading.air_degc;
      row.path_mm[at(beam)] += share * reading.mean_nm / kNmInMm;
    }
    const auto truth = plant_->truth(middle);
    row.true_force_n += share * (truth.force_n - true_zero_.force_n);
    row.true_part_degc = truth.node_degc;  // they move little within the readings
    for (std::size_t i = 0; i < 3; ++i) {
      row.true_mm[i] += share * (truth.position_nm[i] - true_zero_.position_nm[i]) / kNmInMm;
      row.true_r_arcsec[i] += share * (truth.rotation_arcsec[i] - true_zero_.rotation_arcsec[i]);
      row.true_q_mm[i] += share * truth.q_scale_nm[i] / kNmInMm;
    }
  }
  row.time_s = start_s + options_.readings * length_s / 2;
  row.r_arcsec = angles_arcsec(row.time_s - 1);
  for (std::size_t i = 0; i < 3 && options_.readings > 1; ++i) {
    double square_nm2 = 0;
    for (const auto& nm : shown_nm) {
      const double off_nm = nm[i] - row.path_mm[i] * kNmInMm;
      square_nm2 += off_nm * off_nm;
    }
    row.path_std_nm[i] = std::sqrt(square_nm2 / (options_.readings - 1));
  }
  const TimeNs end = instant(start_s + options_.readings * length_s);
  const auto& probes = plant_->parameters().thermometers;
  for (std::size_t i = 0; i < row.t_degc.size(); ++i) {
    const auto& p = probes[i];
    row.t_degc[i] =
        degc_from_ohm(plant_->probe_ohm(p.input, end), p.certificate_r0_ohm, p.a_per_k, p.b_per_k2);
  }
  row.force_n = force_n_;
  return row;
}

void MicroNanoSession::load(double force_n) {
  plant_->set_load(force_n, instant(now_s_));
  force_n_ = force_n;
  while (!plant_->load(instant(now_s_)).resting) now_s_ += 1;
}

MicroNanoRow MicroNanoSession::visit(const Three& q_mm, std::optional<double> dwell_s) {
  for (int axis = 0; axis < kAxes; ++axis) {
    plant_->start_move(axis, q_mm[at(axis)], instant(now_s_));
  }
  const double start_s = now_s_;
  const double reading_s = options_.readings * options_.samples / plant_->sample_rate_hz();
  double end_s = start_s, read_s = start_s + options_.point_s - reading_s - 1;
  if (dwell_s) {
    const auto moving = [&] {
      for (int axis = 0; axis < kAxes; ++axis) {
        if (plant_->axis(axis, instant(end_s)).moving) return true;
      }
      return false;
    };
    end_s += 0.3;  // it is on its way by then
    while (moving()) end_s += 0.1;
    read_s = end_s + *dwell_s;
  }
  MicroNanoRow row = read(read_s);
  row.q_cmd_mm = q_mm;
  row.dwell_s = row.time_s - end_s;
  now_s_ = dwell_s ? read_s + reading_s + 1 : start_s + options_.point_s;
  return row;
}

MicroNanoRow MicroNanoSession::read_again() {
  const MicroNanoRow row = read(now_s_);
  now_s_ += options_.readings * options_.samples / plant_->sample_rate_hz() + 1;
  return row;
}

std::vector<MicroNanoRow> MicroNanoSession::run_grids() {
  std::vector<MicroNanoRow> rows;
  for (int grid = 0; grid < static_cast<int>(options_.grids.size()); ++grid) {
    const auto& plan = options_.grids[at(grid)];
    if (plan.force_n != force_n_) load(plan.force_n);
    const int count = plan.calibration ? 6 : 5;
    const double first_mm = plan.calibration ? 0 : 0.25;
    const auto keep = [&](MicroNanoRow row, int line, bool zero) {
      row.grid = grid;
      row.line = line;
      row.calibration = plan.calibration;
      row.zero = zero;
      rows.push_back(row);
    };
    for (int line = 0; line < count * count; ++line) {
      for (int k = 0; k < count; ++k) {
        const Three q{first_mm + 0.5 * (line / count), first_mm + 0.5 * (line % count),
                      first_mm + 0.5 * k};
        keep(visit(q), line, false);
      }
      keep(visit({0, 0, 0}), line, true);
    }
  }
  return rows;
}

}  // namespace driftwise::testing_support
