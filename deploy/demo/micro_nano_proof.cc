#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "deploy/demo/figures.h"
#include "deploy/demo/reports.h"

namespace driftwise::demo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using nlohmann::json;

constexpr const char* kPose[] = {"x", "y", "z"};

// "x^2:y" -> exponents of x, y, z; nothing for a term with other symbols.
std::optional<std::array<int, 3>> powers_of(const std::string& term) {
  std::array<int, 3> powers{};
  std::istringstream factors(term);
  for (std::string factor; std::getline(factors, factor, ':');) {
    const auto caret = factor.find('^');
    const auto at = std::ranges::find(kPose, factor.substr(0, caret));
    if (at == std::end(kPose)) return std::nullopt;
    powers[static_cast<std::size_t>(at - std::begin(kPose))] +=
        caret == std::string::npos ? 1 : std::stoi(factor.substr(caret + 1));
  }
  return powers;
}

// d q / d pose of the served model at a pose: how a holding error of the axes shows in the pose.
Matrix3d jacobian_at(const json& fit, const Vector3d& pose_mm) {
  Matrix3d jacobian = Matrix3d::Zero();
  for (int row = 0; row < 3; ++row)
    for (const auto& term : fit.at("outputs").at("q" + std::to_string(row + 1)).at("terms")) {
      const auto powers = powers_of(term.at("term").get<std::string>());
      if (!term.at("in").get<bool>() || !powers) continue;
      for (int k = 0; k < 3; ++k) {
        const auto n = static_cast<std::size_t>(k);
        if ((*powers)[n] == 0) continue;
        double slope = term.at("coefficient").get<double>() * (*powers)[n];
        for (int j = 0; j < 3; ++j)
          slope *= std::pow(pose_mm[j], (*powers)[static_cast<std::size_t>(j)] - (j == k ? 1 : 0));
        jacobian(row, k) += slope;
      }
    }
  return jacobian;
}

struct Errors {
  std::vector<double> by_instrument[3], in_truth[3], model_by_instrument[3], model_in_truth[3];
  std::size_t points = 0;
  double air_change_k = 0, force_n = 0;
};

const DatasetColumn& need(const Dataset& data, const std::string& symbol) {
  const auto* column = data.find(symbol);
  if (!column) throw std::runtime_error("a run has no column " + symbol);
  return *column;
}

Errors judge_pose(const std::string& path, const TruthTable& truth, const json& fit) {
  const auto data = read_dataset(path);
  const auto zero_ns = time_zero_ns(data, path);
  Errors errors;
  errors.points = data.rows;
  for (std::size_t i = 0; i < data.rows; ++i) {
    const auto middle_ns = zero_ns + static_cast<std::int64_t>(data.time_s[i] * 1e9);
    Vector3d wanted_mm, holding_mm;
    for (int k = 0; k < 3; ++k) {
      const std::string axis = kPose[k], q = "q" + std::to_string(k + 1);
      wanted_mm[k] = need(data, axis + "_target").values[i];
      holding_mm[k] = need(data, q).values[i] - need(data, q + "_cmd").values[i];
    }
    const Vector3d held_nm = 1e6 * jacobian_at(fit, wanted_mm).partialPivLu().solve(holding_mm);
    for (int k = 0; k < 3; ++k) {
      const std::string axis = kPose[k];
      const double zero_nm = truth.at_zero(axis + "_nm", zero_ns + 1'000'000'000);
      const double seen_nm = 1e6 * (need(data, axis).values[i] - wanted_mm[k]);
      const double true_nm =
          truth.mean_about(axis + "_nm", middle_ns) - zero_nm - 1e6 * wanted_mm[k];
      errors.by_instrument[k].push_back(seen_nm);
      errors.in_truth[k].push_back(true_nm);
      errors.model_by_instrument[k].push_back(seen_nm - held_nm[k]);
      errors.model_in_truth[k].push_back(true_nm - held_nm[k]);
    }
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
    std::printf("  %-4s%9s   %-18s%-18s  %-18s%-18s\n", kPose[k],
                published_nm ? std::to_string(published_nm[k]).c_str() : "",
                text(spread(errors.by_instrument[k])).c_str(),
                text(spread(errors.in_truth[k])).c_str(),
                text(spread(errors.model_by_instrument[k])).c_str(),
                text(spread(errors.model_in_truth[k])).c_str());
}

}  // namespace

void print_micro_nano_proof(const std::string& folder) {
  const TruthTable truth(folder + "/truth.csv");
  const json fit = read_json(folder + "/GTF.json");
  constexpr int kPublished_nm[] = {98, 81, 52};
  std::printf(
      "\nU90 (mean) in nm at new positions, pose coordinates\n  %-4s%9s   %-36s  %-36s\n"
      "  %-4s%9s   %-18s%-18s  %-18s%-18s\n",
      "", "published", "where the end-effector came to rest", "holding error taken out", "", "2011",
      "instruments", "truth", "instruments", "truth");
  print_rows("geometry, temperatures and force",
             judge_pose(folder + "/compensated.csv", truth, fit), kPublished_nm);
  print_rows("the same with products of force and t04 with the pose",
             judge_pose(folder + "/products.csv", truth, read_json(folder + "/products.json")),
             nullptr);
  print_rows("geometry only", judge_pose(folder + "/geometry.csv", truth, fit), nullptr);
}

}  // namespace driftwise::demo
