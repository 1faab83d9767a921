// hidden_effects_sweep: hides effects in many data sets and counts what was named.
//
// Every data set's outcome is a line of the results file, under a key that says how it was made;
// what is there already is not made again, so a sweep that was stopped goes on where it was.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <set>

#include "tests/hidden_effects/shapes/sweep_plan.h"

int main(int count, char** arguments) {
  using namespace driftwise::hidden;
  CLI::App app(
      "Hides effects in data sets, diagnoses them and counts. The results file keeps every "
      "outcome.");
  SweepPlan plan;
  std::string results = "hidden_effects.tsv";
  bool report_only = false, check = false;
  app.add_option("--kind", plan.kind, "null, single, pair, triple, uncatalogued, fault")
      ->check(CLI::IsMember({"null", "single", "pair", "triple", "uncatalogued", "fault"}))
      ->capture_default_str();
  app.add_option("--robot", plan.robot, "linear, micro")
      ->check(CLI::IsMember({"linear", "micro"}))
      ->capture_default_str();
  app.add_option("--cause", plan.cause, "only this one (single, pair)");
  app.add_option("--chi2", plan.chi2, "strengths")->delimiter(',')->capture_default_str();
  app.add_option("--rho", plan.autocorrelation, "autocorrelations")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--sets", plan.sets, "data sets per case")->capture_default_str();
  app.add_option("--seed", plan.seed, "of the first")->capture_default_str();
  app.add_flag("--two-times", plan.two_times, "noise with two correlation times");
  app.add_option("--hold", plan.hold_nm,
                 "nm that the robot stands off its places at most; the noise is then the pose's");
  app.add_option("--results", results, "outcomes, one per line")->capture_default_str();
  app.add_flag("--report", report_only, "only counts what is there");
  app.add_flag("--check", check, "fail where an interval excludes a promise");
  CLI11_PARSE(app, count, arguments);

  auto done = read_results(results);
  if (!report_only) {
    const auto cases = cases_of(plan);
    std::set<std::string> known;
    for (const auto& one : done) known.insert(one.key);
    std::ofstream out(results, std::ios::app);
    std::size_t made = 0;
    for (const auto& one : cases) {
      ++made;
      if (known.contains(one.key)) continue;
      try {
        done.push_back({one.key, one.group, judged(one.world, one.hidden, one.seed)});
      } catch (const std::exception& problem) {
        std::cerr << one.key << ": " << problem.what() << "\n";
        return 2;
      }
      out << line_of(done.back()) << std::flush;
      if (isatty(STDERR_FILENO) != 0)
        std::fprintf(stderr, "\r\x1b[K%zu of %zu  %s", made, cases.size(), one.key.c_str());
    }
    if (isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "\n");
  }
  const auto broken = print_report(done, std::cout);
  if (check)
    for (const auto& one : broken) std::cout << "promise not kept: " << one << "\n";
  return check && !broken.empty() ? 1 : 0;
}
