#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "deploy/demo/figures.h"
#include "deploy/demo/reports.h"

namespace driftwise::demo {
namespace {

constexpr const char* kPose[] = {"x", "y", "z"};

struct Errors {
  ByInstrument instrument[3];
  ErrorFigures truth[3];
  std::size_t points = 0;
  double air_change_k = 0, force_n = 0;
};

const DatasetColumn& need(const Dataset& data, const std::string& symbol) {
  const auto* column = data.find(symbol);
  if (!column) throw std::runtime_error("a run has no column " + symbol);
  return *column;
}

// By the instruments: as `driftwise run verify` says. In truth: by the plant's private log.
Errors judge_pose(const std::string& stem, const TruthTable& truth) {
  const auto path = stem + ".csv";
  const auto data = read_dataset(path);
  const auto verification = read_json(stem + ".verify.json");
  const auto zero_ns = time_zero_ns(data, path);
  const auto late_ns = half_of_shortest_step_ns(data);
  Errors errors;
  for (int k = 0; k < 3; ++k) {
    const std::string axis = kPose[k];
    errors.instrument[k] = by_instrument(verification, axis);
    const double zero_nm = truth.at_zero(axis + "_nm", zero_ns + 1'000'000'000);
    std::vector<double> in_truth;
    for (std::size_t i = 0; i < data.rows; ++i) {
      if (!data.zero.empty() && data.zero[i] != 0) continue;
      const auto middle_ns = zero_ns + static_cast<std::int64_t>(data.time_s[i] * 1e9);
      in_truth.push_back(1e6 * need(data, axis + "_target").values[i] -
                         (truth.mean_about(axis + "_nm", middle_ns, late_ns) - zero_nm));
    }
    errors.truth[k] = error_figures(in_truth);
    errors.points = in_truth.size();
  }
  const auto [low, high] = std::ranges::minmax(need(data, "air_x").values);
  errors.air_change_k = high - low;
  errors.force_n = need(data, "force").values.front();
  return errors;
}

void print_rows(const char* label, const Errors& errors, const int* published_nm) {
  std::printf("%s: %zu points under %.3f N, air %+.2f K\n", label, errors.points, errors.force_n,
              errors.air_change_k);
  for (int k = 0; k < 3; ++k)
    std::printf("  %-4s%9s   %-22s%-22s  %-22s\n", kPose[k],
                published_nm ? std::to_string(published_nm[k]).c_str() : "",
                text(errors.instrument[k].all).c_str(), text(errors.truth[k]).c_str(),
                errors.instrument[k].by_model ? text(*errors.instrument[k].by_model).c_str() : "-");
}

}  // namespace

void print_micro_nano_proof(const std::string& folder) {
  const TruthTable truth(folder + "/truth.csv");
  constexpr int kPublished_nm[] = {98, 81, 52};
  std::printf(
      "\nA90 (mean, S90) in nm, target minus measured, pose coordinates\n  %-4s%9s   %-44s  %-22s\n"
      "  %-4s%9s   %-22s%-22s  %-22s\n",
      "", "U90", "where the end-effector came to rest", "holding error taken out", "", "2011",
      "instruments", "truth", "instruments");
  print_rows("geometry, temperatures and force", judge_pose(folder + "/compensated", truth),
             kPublished_nm);
  print_rows("the same with products of force and t04 with the pose",
             judge_pose(folder + "/products", truth), nullptr);
  print_rows("geometry only", judge_pose(folder + "/geometry", truth), nullptr);
}

}  // namespace driftwise::demo
