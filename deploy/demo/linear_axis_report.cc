#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "deploy/demo/figures.h"
#include "deploy/demo/reports.h"

namespace driftwise::demo {
namespace {

using nlohmann::json;

std::string dropped_sensors(const json& output) {
  std::string names;
  for (const auto& term : output.at("terms"))
    if (!term.at("in").get<bool>())
      names += (names.empty() ? "" : " ") + term.at("term").get<std::string>();
  return names.empty() ? "none" : names;
}

}  // namespace

void print_linear_axis_fits(const std::string& folder) {
  struct Row {
    const char *label, *file, *published;
  };
  const Row rows[] = {{"geometry only", "geometry", "206"},
                      {"geometry + 10 temperatures", "ten", "9"},
                      {"only the 6 sensors on the robot", "six", "15"},
                      {"first 300 points only, 10 temperatures", "first300", "40"}};
  std::printf(
      "\nS90 in nm on points that took no part in the fit        published    here: validation   "
      "held out by    terms   fit\n");
  std::printf("%-56s%9s    %17s   %-15s%5s\n", "", "2011", "(half millimetres)", "blocks of time",
              "in");
  for (const Row& row : rows) {
    const json fit = read_json(folder + "/" + row.file + ".json");
    const json& q1 = fit.at("outputs").at("q1");
    std::printf("%-56s%9s    %17.1f   %-15.1f%5d   %.2f ms\n", row.label, row.published,
                figure(q1, "u90_validation_nm"), figure(q1, "u90_blocks_nm"), terms_in(q1),
                fit.at("fit_us").get<double>() / 1000);
  }
  const json ten = read_json(folder + "/ten.json");
  std::printf(
      "\ncalibration %lld points, validation %lld points, S90 on the calibration points %.1f nm "
      "(published 9)\n",
      ten.at("rows").at("calibration").get<long long>(),
      ten.at("rows").at("validation").get<long long>(),
      figure(ten.at("outputs").at("q1"), "u90_calibration_nm"));
  std::printf("dropped by the regression: %s (published: the stabilised base, the lower arm)\n",
              dropped_sensors(ten.at("outputs").at("q1")).c_str());
  const json offers = read_json(folder + "/offers.json");
  std::printf(
      "\nmore terms, and what each would change in the held-out S90 (published: all rejected, 4th "
      "order got stuck)\n");
  for (const auto& offer : offers.at("offers")) {
    const double before = figure(offer, "u90_validation_before_nm"),
                 after = figure(offer, "u90_validation_after_nm");
    const double blocks_before = figure(offer, "u90_blocks_before_nm"),
                 blocks_after = figure(offer, "u90_blocks_after_nm");
    std::string taken;
    for (const auto& term : offer.at("taken"))
      taken += (taken.empty() ? "" : " ") + term.get<std::string>();
    if (taken.empty())
      std::printf("  %-48s all rejected: +0.0 nm\n", offer.at("offer").get<std::string>().c_str());
    else
      std::printf("  %-48s %+.1f nm, by blocks of time %+.1f nm; stepwise takes %s\n",
                  offer.at("offer").get<std::string>().c_str(), after - before,
                  blocks_after - blocks_before, taken.c_str());
  }
}

namespace {

// By the instrument: as `driftwise run verify` says. In truth: by the plant's private log, which no
// user has; model_in_truth leaves out how far the axis rested from its own command.
struct Proof {
  std::size_t points = 0;
  ByInstrument instrument;
  ErrorFigures truth, model_in_truth;
  double air_change_k = 0;
};

// Where the end-effector was at each accepted point but returns to zero, relative to the run's
// zero: target minus truth, as the verification counts it.
Proof judge(const std::string& stem, const TruthTable& truth) {
  const auto csv_path = stem + ".csv";
  const auto data = read_dataset(csv_path);
  const auto zero_ns = time_zero_ns(data, csv_path);
  const auto* wanted = data.find("x_target") ? data.find("x_target") : data.find("q1_cmd");
  const auto* air = data.find("t04");
  const auto* q = data.find("q1");
  const auto* q_cmd = data.find("q1_cmd");
  if (!wanted || !q || !q_cmd) throw std::runtime_error(csv_path + ": no q1_mm or wanted position");
  const double at_zero_nm = truth.at_zero("end_effector_nm", zero_ns + 1'000'000'000);
  const auto late_ns = half_of_shortest_step_ns(data);
  std::vector<double> in_truth, model_in_truth;
  for (std::size_t i = 0; i < data.rows; ++i) {
    if (!data.zero.empty() && data.zero[i] != 0) continue;
    const auto middle_ns = zero_ns + static_cast<std::int64_t>(data.time_s[i] * 1e9);
    in_truth.push_back(1e6 * wanted->values[i] -
                       (truth.mean_about("end_effector_nm", middle_ns, late_ns) - at_zero_nm));
    model_in_truth.push_back(in_truth.back() + 1e6 * (q->values[i] - q_cmd->values[i]));
  }
  Proof proof{in_truth.size(), by_instrument(read_json(stem + ".verify.json"), "x"),
              error_figures(in_truth), error_figures(model_in_truth), 0};
  if (air) {
    const auto [low, high] = std::ranges::minmax(air->values);
    proof.air_change_k = high - low;
  }
  return proof;
}

}  // namespace

void print_linear_axis_proof(const std::string& folder) {
  const TruthTable truth(folder + "/truth.csv");
  struct Row {
    const char *label, *file;
    Proof proof;
  };
  std::vector<Row> rows = {{"without compensation (q = x)", "none", {}},
                           {"geometry only", "geometry", {}},
                           {"ten sensors", "ten", {}},
                           {"six sensors on the robot", "six", {}}};
  std::printf(
      "\nA90 (mean, S90) in nm, target minus measured       where the axis came to rest            "
      "   "
      "holding error taken out\n");
  std::printf("%-28s%6s%8s   %-22s%-22s  %-22s%-22s\n", "", "points", "air", "interferometer",
              "truth", "interferometer", "truth");
  const auto by_model = [](const Proof& proof) { return proof.instrument.by_model; };
  for (auto& row : rows) {
    row.proof = judge(folder + "/" + row.file, truth);
    std::printf("%-28s%6zu%6.2f K   %-22s%-22s  %-22s%-22s\n", row.label, row.proof.points,
                row.proof.air_change_k, text(row.proof.instrument.all).c_str(),
                text(row.proof.truth).c_str(),
                by_model(row.proof) ? text(*by_model(row.proof)).c_str() : "-",
                text(row.proof.model_in_truth).c_str());
  }
  const Proof &ten = rows[2].proof, &six = rows[3].proof;
  const auto a90_by_model = [&](const Proof& proof) {
    return by_model(proof).value_or(proof.instrument.all).a90;
  };
  std::printf(
      "\nThe ten-sensor model learnt robot and interferometer together: by the interferometer it "
      "is right to %.1f nm, in truth to\n"
      "%.1f nm, for it teaches the robot the instrument's drift. The six-sensor model sees the "
      "robot alone: %.1f nm by the\n"
      "interferometer, %.1f nm in truth. %s\n",
      a90_by_model(ten), ten.model_in_truth.a90, a90_by_model(six), six.model_in_truth.a90,
      six.model_in_truth.a90 < ten.model_in_truth.a90
          ? "That is the one to serve, though the instrument likes the other better."
          : "In this hour the instrument hardly drifted, so the two do not differ in the sense one "
            "expects.");
}

}  // namespace driftwise::demo
