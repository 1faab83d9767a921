#include "tests/hidden_effects/sweep_plan.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/beta.hpp>
#include <cstdio>
#include <fstream>
#include <map>
#include <ostream>
#include <sstream>

namespace driftwise::hidden {
namespace {

constexpr double kConfidence = 0.95, kIdentifiable = 20;

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
  if (plan.kind == "pair" || plan.kind == "triple") {
    const std::size_t n = all.size();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) {
        if (!wanted(all[i]) && !wanted(all[j])) continue;
        if (plan.kind == "pair")
          sets.push_back({all[i], all[j]});
        else if ((i + j) % 5 == 0 && j + 2 < n)
          sets.push_back({all[i], all[j], all[j + 2]});
      }
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

std::string percent(const Rate& rate) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "%4d of %4d  %5.1f %% (%.1f to %.1f)", rate.hits,
                rate.sets, rate.sets > 0 ? 100.0 * rate.hits / rate.sets : 0.0, 100 * rate.low(),
                100 * rate.high());
  return text.data();
}

struct Count {
  Rate exact, set, subject, false_name, covers, unexplained;
  double gain = 0, gain_of_truth = 0, seconds = 0;
  std::vector<double> widths;
  std::map<std::string, int> wrong;
  void add(const Outcome& one) {
    const auto count = [](Rate& rate, bool hit) { rate.hits += hit ? 1 : 0, ++rate.sets; };
    count(exact, one.exact);
    count(set, one.exact_or_set);
    count(subject, one.subject);
    count(false_name, one.false_names > 0);
    count(unexplained, one.verdict == "unexplained");
    if (one.covers >= 0) count(covers, one.covers == 1);
    if (one.width_over_bound > 0) widths.push_back(one.width_over_bound);
    gain += one.gain, gain_of_truth += one.gain_of_truth, seconds += one.seconds;
    if (!one.exact) ++wrong[one.named.empty() ? "-" : one.named];
  }
};

}  // namespace

double Rate::low() const {
  if (hits == 0 || sets == 0) return 0;
  return boost::math::quantile(boost::math::beta_distribution<double>(hits, sets - hits + 1),
                               (1 - kConfidence) / 2);
}

double Rate::high() const {
  if (hits == sets) return 1;
  return boost::math::quantile(boost::math::beta_distribution<double>(hits + 1, sets - hits),
                               (1 + kConfidence) / 2);
}

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
          if (rho > 0.9) one.world.slow_share = 0.9;
          one.seed = seed;
          one.group = plan.kind + " " + plan.robot + " " + joined(hidden) +
                      (strong ? " chi2=" + number(chi2) : "") + " rho=" + number(rho) +
                      (plan.two_times ? " two" : "");
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

std::vector<std::string> print_report(const std::vector<SweepResult>& results, std::ostream& out) {
  std::map<std::string, Count> groups;
  std::vector<std::string> broken;
  for (const auto& one : results) {
    std::string group = one.group;
    if (group.starts_with("pair") || group.starts_with("triple"))
      group = group.substr(0, group.find(' ', group.find(' ') + 1)) + " (all)" +
              group.substr(group.find(" chi2"));
    if (group.starts_with("single")) {
      const std::string suffix =
          one.outcome.identifiable > kIdentifiable ? "" : " (not identifiable)";
      group += suffix;
      const std::string robot = group.substr(0, group.find(' ', group.find(' ') + 1));
      groups[robot + " (all)" + group.substr(group.find(" chi2"))].add(one.outcome);
    }
    groups[group].add(one.outcome);
  }
  for (auto& [name, count] : groups) {
    const bool null = name.starts_with("null"), unknown = name.starts_with("uncatalogued");
    out << name << "\n  exact " << percent(count.exact) << "   or in its set " << percent(count.set)
        << "\n  false name " << percent(count.false_name) << "   unexplained "
        << count.unexplained.hits << "   right subject " << count.subject.hits << "   "
        << number(count.seconds / count.exact.sets) << " s each\n";
    if (count.covers.sets > 0) {
      std::ranges::sort(count.widths);
      out << "  interval covers " << percent(count.covers) << "   width over bound, median "
          << (count.widths.empty() ? "-" : number(count.widths[count.widths.size() / 2])) << "\n";
    }
    if (!null && count.gain_of_truth > 0)
      out << "  held-out gain " << number(count.gain / count.gain_of_truth)
          << " of what the truth gives\n";
    std::vector<std::pair<int, std::string>> wrong;
    for (const auto& [what, times] : count.wrong) wrong.emplace_back(times, what);
    std::ranges::sort(wrong, std::ranges::greater{});
    for (std::size_t i = 0; i < std::min<std::size_t>(wrong.size(), 4); ++i)
      if (!null || wrong[i].second != "-")
        out << "    " << wrong[i].first << " x " << wrong[i].second << "\n";
    const auto promise = [&](const Rate& rate, double least, const std::string& what) {
      if (rate.sets > 0 && rate.high() < least)
        broken.push_back(name + ": " + what + " " + percent(rate));
    };
    const auto at_most = [&](const Rate& rate, double most, const std::string& what) {
      if (rate.sets > 0 && rate.low() > most)
        broken.push_back(name + ": " + what + " " + percent(rate));
    };
    if (null) at_most(count.false_name, 0.01, "false names");
    if (unknown) at_most(count.false_name, 0.03, "misnamed");
    if (name.starts_with("pair")) promise(count.set, 0.9, "exact or in its set");
    if (!name.starts_with("single")) continue;
    const bool identifiable = !name.ends_with("(not identifiable)");
    const double chi2 = std::stod(name.substr(name.find("chi2=") + 5));
    const double rho = std::stod(name.substr(name.find("rho=") + 4));
    if (chi2 < 50 || rho > 0.5) continue;
    if (identifiable) promise(count.exact, chi2 > 100 ? 0.98 : 0.95, "named exactly");
    if (!identifiable) promise(count.set, 0.9, "the set");
    promise(count.covers, 0.85, "interval covers");
    at_most(count.covers, 0.95, "interval covers");
  }
  return broken;
}

}  // namespace driftwise::hidden
