// coverage: over many simulated campaigns, how often the true end-effector lies within
// the expanded uncertainty (k = 2) that the served model states. Progress on stderr, the table on
// stdout. Exit code 1: an interval by campaign excludes 93 .. 97 %.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/statistics/coverage_cases.h"
#include "tests/statistics/coverage_run.h"

int main(int argc, char** argv) {
  using namespace driftwise::statistics;
  CLI::App app{
      "Coverage of the stated uncertainty over simulated campaigns.\n"
      "  coverage --campaigns 500\n  coverage --plant linear-axis --campaigns 40"};
  std::string plant = "micro-nano";
  int campaigns = 500, threads = 1;
  std::uint64_t seed = 1;
  app.add_option("--plant", plant)->check(CLI::IsMember(case_names()))->capture_default_str();
  app.add_option("--campaigns", campaigns)->check(CLI::Range(1, 100000))->capture_default_str();
  app.add_option("--first-seed", seed)->capture_default_str();
  app.add_option("--threads", threads)->check(CLI::Range(1, 64))->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    const auto outputs =
        run_coverage(case_named(plant), seed, campaigns, threads,
                     [&](int done, const std::vector<CoverageOfOutput>& so_far) {
                       std::fprintf(stderr, "\r%d of %d campaigns", done, campaigns);
                       for (const auto& output : so_far)
                         std::fprintf(stderr, "  %s %.2f %%", output.channel.c_str(),
                                      100 * output.inside.rate());
                     });
    std::fprintf(stderr, "\n");
    std::printf(
        "%s, seeds %llu .. %llu\n%s", plant.c_str(), static_cast<unsigned long long>(seed),
        static_cast<unsigned long long>(seed) + static_cast<unsigned long long>(campaigns) - 1,
        coverage_table(outputs).c_str());
    const auto interval = outputs.back().inside.clustered();  // of all coordinates
    return interval.high >= 0.93 && interval.low <= 0.97 ? 0 : 1;
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "\n%s\n", problem.what());
    return 3;
  }
}
