#include "tests/support/plant_campaign.h"

#include <cmath>

#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::testing_support {
namespace {

using simulated::LinearAxisPlant;
using simulated::TimeNs;

constexpr double kNmPerMm = 1e6;
constexpr int kReadings = 4;

TimeNs ns(double seconds) { return static_cast<TimeNs>(std::llround(seconds * 1e9)); }

std::vector<double> pass_mm() {
  std::vector<double> positions{0};
  for (int half = -8; half <= 8; ++half) positions.push_back(half / 2.0);
  return positions;
}

// One group of readings that ends before the point's time is over.
CampaignRow read_group(LinearAxisPlant& plant, TimeNs start, int samples) {
  CampaignRow row;
  const TimeNs length = ns(samples / plant.sample_rate_hz());
  std::array<double, kReadings> x_nm{};
  for (int k = 0; k < kReadings; ++k) {
    const TimeNs begin = start + k * length;
    const TimeNs middle = begin + length / 2;
    row.q1_mm += plant.axis(0, middle).q_mm / kReadings;
    x_nm[static_cast<std::size_t>(k)] = plant.measure_length(0, begin, samples).mean_nm;
    const auto truth = plant.truth(middle);
    row.end_effector_nm += truth.end_effector_nm / kReadings;
    row.geometry_nm += truth.geometry_nm / kReadings;
    row.robot_drift_nm += truth.robot_drift_nm / kReadings;
    row.device_drift_nm += truth.device_drift_nm / kReadings;
    row.air_error_nm += truth.air_error_nm / kReadings;
    if (k == kReadings / 2) {
      const auto& probes = plant.parameters().thermometers;
      for (std::size_t i = 0; i < row.t_degc.size(); ++i) {
        const auto& p = probes[i];
        row.t_degc[i] = degc_from_ohm(plant.probe_ohm(p.input, begin + length),
                                      p.certificate_r0_ohm, p.a_per_k, p.b_per_k2);
      }
    }
  }
  double mean_nm = 0, square_nm2 = 0;
  for (const double value : x_nm) mean_nm += value / kReadings;
  for (const double value : x_nm) square_nm2 += (value - mean_nm) * (value - mean_nm);
  row.x_mm = mean_nm / kNmPerMm;
  row.x_std_nm = std::sqrt(square_nm2 / (kReadings - 1));
  return row;
}

}  // namespace

double degc_from_ohm(double ohm, double r0_ohm, double a_per_k, double b_per_k2) {
  const double c = 1 - ohm / r0_ohm;
  return 2 * -c / (a_per_k + std::sqrt(a_per_k * a_per_k - 4 * b_per_k2 * c));
}

Campaign run_plant_campaign(LinearAxisPlant& plant, TimeNs epoch, const CampaignOptions& options) {
  constexpr double kSettling_s = 11.5;  // of a point's 14.3 s before its readings
  Campaign campaign;
  double time_s = 0;
  plant.start_reference(0, epoch);
  time_s += 15;
  campaign.zero_s = time_s;
  plant.zero_length(0, epoch + ns(time_s));
  campaign.zero_end_effector_nm = plant.truth(epoch + ns(time_s)).end_effector_nm;
  for (int pass = 0; pass < options.passes; ++pass) {
    for (const double target_mm : pass_mm()) {
      plant.start_move(0, target_mm, epoch + ns(time_s));
      double read_s = time_s + kSettling_s;
      CampaignRow row;
      for (int attempt = 0; attempt < 10; ++attempt) {
        row = read_group(plant, epoch + ns(read_s), options.samples);
        row.time_s = read_s + kReadings / 2.0 * options.samples / plant.sample_rate_hz();
        campaign.group_std_nm.push_back(row.x_std_nm);
        if (row.x_std_nm <= options.gate_nm) break;
        ++campaign.rejected_groups;
        read_s += 2.5;
      }
      row.q1_cmd_mm = target_mm;
      row.calibration = target_mm == std::round(target_mm);
      campaign.rows.push_back(row);
      time_s = read_s - kSettling_s + options.point_s;
    }
  }
  return campaign;
}

}  // namespace driftwise::testing_support
