#include "tests/hidden_effects/shapes/sweep_plan.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "tests/hidden_effects/shapes/sweep_triples.h"

namespace driftwise::hidden {
namespace {

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

std::vector<std::vector<Hidden>> hidden_of(const SweepPlan& plan, Robot robot, std::uint64_t seed,
                                           double chi2) {
  if (plan.kind == "null") return {{}};
  std::vector<Hidden> all = hideable(robot, seed);
  if (plan.kind == "uncatalogued") all = uncatalogued();
  if (plan.kind == "fault") all = faults();
  for (auto& one : all) one.chi2 = chi2;
  std::vector<std::vector<Hidden>> sets;
  const auto wanted = [&](const Hidden& one) {
    return plan.cause.empty() || one.cause == plan.cause;
  };
  if (plan.kind == "pair") {
    const std::size_t n = all.size();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j)
        if (wanted(all[i]) || wanted(all[j])) sets.push_back({all[i], all[j]});
    return sets;
  }
  if (plan.kind == "triple") {
    for (auto& three : triples_of(all))
      if (std::ranges::any_of(three, wanted)) sets.push_back(std::move(three));
    return sets;
  }
  for (const auto& one : all)
    if (wanted(one)) sets.push_back({one});
  return sets;
}

std::string joined(const std::vector<Hidden>& hidden) {
  std::string text;
  for (const auto& one : hidden)
    text += (text.empty() ? "" : "+") + one.cause +
            (one.cause == "sensor_fault" ? (one.parameter > 0 ? ":jump" : ":frozen") : "");
  return text.empty() ? "nothing" : text;
}

}  // namespace

std::vector<SweepCase> cases_of(const SweepPlan& plan) {
  std::vector<SweepCase> cases;
  const Robot robot = plan.robot == "linear" ? Robot::linear_axis : Robot::micro_nano;
  const bool strong = plan.kind == "single" || plan.kind == "pair" || plan.kind == "triple" ||
                      plan.kind == "uncatalogued";
  for (const double rho : plan.autocorrelation)
    for (const double chi2 : strong ? plan.chi2 : std::vector<double>{0})
      for (int k = 0; k < plan.sets; ++k) {
        const std::uint64_t seed = plan.seed + static_cast<std::uint64_t>(k);
        for (auto& hidden : hidden_of(plan, robot, seed, chi2)) {
          SweepCase one;
          one.world.robot = robot;
          one.world.autocorrelation = rho;
          one.world.two_times = plan.two_times;
          one.world.hold_nm = plan.hold_nm;
          one.world.noise_in_pose = plan.hold_nm > 0;
          if (rho > 0.9) one.world.slow_share = 0.9;
          one.seed = seed;
          one.group = plan.kind + " " + plan.robot + " " + joined(hidden) +
                      (strong ? " chi2=" + number(chi2) : "") + " rho=" + number(rho) +
                      (plan.two_times ? " two" : "") +
                      (plan.hold_nm > 0 ? " hold=" + number(plan.hold_nm) : "");
          one.key = one.group + " seed=" + std::to_string(seed);
          one.hidden = std::move(hidden);
          cases.push_back(std::move(one));
        }
      }
  return cases;
}

std::string line_of(const SweepResult& result) {
  const Outcome& o = result.outcome;
  std::ostringstream out;
  out << result.key << '\t' << result.group << '\t' << o.exact << '\t' << o.exact_or_set << '\t'
      << o.subject << '\t' << o.false_names << '\t' << (o.named.empty() ? "-" : o.named) << '\t'
      << o.verdict << '\t' << o.identifiable << '\t' << o.covers << '\t' << o.width_over_bound
      << '\t' << o.gain << '\t' << o.gain_of_truth << '\t' << o.seconds << '\t' << o.note
      << "\t.\n";
  return out.str();
}

std::vector<SweepResult> read_results(const std::string& path) {
  std::vector<SweepResult> results;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    std::vector<std::string> f;
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, '\t');) f.push_back(field);
    if (f.size() != 16) continue;  // cut off by a stop: that data set is made again
    results.push_back({f[0],
                       f[1],
                       {f[2] == "1", f[3] == "1", f[4] == "1", std::stoi(f[5]),
                        f[6] == "-" ? "" : f[6], f[7], f[14], std::stod(f[8]), std::stoi(f[9]),
                        std::stod(f[10]), std::stod(f[11]), std::stod(f[12]), std::stod(f[13])}});
  }
  return results;
}

}  // namespace driftwise::hidden
