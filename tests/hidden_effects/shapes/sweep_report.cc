// What the outcomes of a sweep count up to.

#include <algorithm>
#include <array>
#include <boost/math/distributions/beta.hpp>
#include <cstdio>
#include <map>
#include <ostream>
#include <set>

#include "tests/hidden_effects/shapes/sweep_plan.h"

namespace driftwise::hidden {
namespace {

constexpr double kConfidence = 0.95, kIdentifiable = 20;

std::string short_number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

std::string percent(const Rate& rate) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "%4d of %4d  %5.1f %% (%.1f to %.1f)", rate.hits,
                rate.sets, rate.sets > 0 ? 100.0 * rate.hits / rate.sets : 0.0, 100 * rate.low(),
                100 * rate.high());
  return text.data();
}

void count_one(Rate& rate, bool hit) {
  rate.hits += hit ? 1 : 0;
  ++rate.sets;
}

struct Count {
  Rate exact, set, subject, false_name, covers, unexplained;
  double gain = 0, gain_of_truth = 0, seconds = 0;
  std::vector<double> widths;
  std::map<std::string, int> wrong;
  void add(const Outcome& one) {
    count_one(exact, one.exact);
    count_one(set, one.exact_or_set);
    count_one(subject, one.subject);
    count_one(false_name, one.false_names > 0);
    count_one(unexplained, one.verdict == "unexplained");
    if (one.covers >= 0) count_one(covers, one.covers == 1);
    if (one.width_over_bound > 0) widths.push_back(one.width_over_bound);
    gain += one.gain, gain_of_truth += one.gain_of_truth, seconds += one.seconds;
    if (!one.exact) ++wrong[one.named.empty() ? "-" : one.named];
  }
};

// "single linear creep chi2=75 rho=0.3": its words.
struct SingleGroup {
  std::string robot, cause, rest;
  double chi2 = 0;
};
SingleGroup single_group(const std::string& group) {
  const auto robot = group.find(' ') + 1, cause = group.find(' ', robot) + 1;
  const auto chi2 = group.find(" chi2=", cause), rest = group.find(' ', chi2 + 1);
  return {group.substr(robot, cause - robot - 1), group.substr(cause, chi2 - cause),
          group.substr(rest + 1), std::stod(group.substr(chi2 + 6))};
}

// Cause by strength: how many were named exactly, and with the reported set.
void print_detection_curve(const std::vector<SweepResult>& results, std::ostream& out) {
  struct Cell {
    Rate exact, set;
  };
  std::map<std::string, std::map<std::string, std::map<double, Cell>>> tables;
  std::map<std::string, std::set<double>> strengths;
  for (const auto& one : results) {
    if (!one.group.starts_with("single")) continue;
    const auto group = single_group(one.group);
    const std::string table = group.robot + ", " + group.rest;
    auto& cell = tables[table][group.cause][group.chi2];
    count_one(cell.exact, one.outcome.exact);
    count_one(cell.set, one.outcome.exact_or_set);
    strengths[table].insert(group.chi2);
  }
  for (const auto& [table, causes] : tables) {
    out << "\ndetection curve, " << table
        << ": named exactly (with the reported set), of data sets\n\n| chi2 |";
    for (const double chi2 : strengths[table]) out << " " << short_number(chi2) << " |";
    out << "\n|---|";
    for (std::size_t k = 0; k < strengths[table].size(); ++k) out << "---|";
    out << "\n";
    for (const auto& [cause, cells] : causes) {
      out << "| `" << cause << "` |";
      for (const double chi2 : strengths[table]) {
        const auto cell = cells.find(chi2);
        if (cell == cells.end()) {
          out << " |";
          continue;
        }
        const auto& [exact, set] = cell->second;
        out << " " << exact.hits;
        if (set.hits != exact.hits) out << " (" << set.hits << ")";
        out << " of " << exact.sets << " |";
      }
      out << "\n";
    }
  }
}

// Per cause with a searched parameter, over all strengths promised for, identifiable ones.
void print_interval_cover(const std::vector<SweepResult>& results, std::ostream& out) {
  struct Cover {
    Rate covers;
    std::vector<double> widths;
  };
  std::map<std::string, Cover> causes;
  for (const auto& one : results) {
    if (!one.group.starts_with("single") || one.outcome.covers < 0) continue;
    const auto group = single_group(one.group);
    if (one.outcome.identifiable <= kIdentifiable || group.chi2 < 50) continue;
    for (const std::string& name : {group.cause, std::string("all together")}) {
      auto& cover = causes[group.robot + " " + name];
      count_one(cover.covers, one.outcome.covers == 1);
      if (one.outcome.width_over_bound > 0) cover.widths.push_back(one.outcome.width_over_bound);
    }
  }
  if (causes.empty()) return;
  out << "\n90 % intervals of the searched parameter, identifiable, chi2 from 50 on\n\n"
         "| cause | cover the truth | median width over the Cramer-Rao bound's |\n|---|---|---|\n";
  for (auto& [name, cover] : causes) {
    std::ranges::sort(cover.widths);
    out << "| " << name << " | " << percent(cover.covers) << " | "
        << (cover.widths.empty() ? "-" : short_number(cover.widths[cover.widths.size() / 2]))
        << " |\n";
  }
}

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
    if (group.starts_with("uncatalogued"))
      groups[group.substr(0, group.find(' ', group.find(' ') + 1)) + " (all)" +
             group.substr(group.find(" chi2"))]
          .add(one.outcome);
    groups[group].add(one.outcome);
  }
  for (auto& [name, count] : groups) {
    const bool null = name.starts_with("null"), unknown = name.starts_with("uncatalogued");
    out << name << "\n  exact " << percent(count.exact) << "   or in its set " << percent(count.set)
        << "\n  false name " << percent(count.false_name) << "   unexplained "
        << count.unexplained.hits << "   right subject " << count.subject.hits << "   "
        << short_number(count.seconds / count.exact.sets) << " s each\n";
    if (count.covers.sets > 0) {
      std::ranges::sort(count.widths);
      out << "  interval covers " << percent(count.covers) << "   width over bound, median "
          << (count.widths.empty() ? "-" : short_number(count.widths[count.widths.size() / 2]))
          << "\n";
    }
    if (!null && count.gain_of_truth > 0)
      out << "  held-out gain " << short_number(count.gain / count.gain_of_truth)
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
    if (unknown && name.find("(all)") != std::string::npos)
      at_most(count.false_name, 0.03, "misnamed");
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
  print_interval_cover(results, out);
  print_detection_curve(results, out);
  return broken;
}

}  // namespace driftwise::hidden
