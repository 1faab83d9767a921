// Counts how often the end of a run lies in the band that was stated
// (docs/evidence/time_to_end.md).

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>

#include "tests/statistics/time_to_end/restless_cell.h"

int main(int argc, char** argv) {
  using namespace driftwise::tests;
  CLI::App app("How often the end of a run lies in the stated 80 % band");
  int cells = 10, runs = 10, before = 4;
  unsigned seed = 1000;
  bool development = false;
  app.add_option("--cells", cells, "each with a history of its own");
  app.add_option("--runs", runs, "of each cell that count");
  app.add_option("--before", before, "runs of each cell before them");
  app.add_option("--seed", seed);
  app.add_flag("--development", development, "the populations the estimator was developed on");
  CLI11_PARSE(app, argc, argv);
  spdlog::set_level(spdlog::level::off);
  const auto populations = development ? development_populations() : counted_populations();
  fmt::print(
      "| population | runs of history | asked at | runs | inside | ended early | ended late "
      "| band, of what was ahead |\n|---|---|---|---|---|---|---|---|\n");
  for (const auto& population : populations) {
    TimeToEnd count;
    for (int cell = 0; cell < cells; ++cell)
      count_cell(population, seed + static_cast<unsigned>(cell), before, runs, count);
    for (std::size_t i = 0; i < kAskedAt.size(); ++i) {
      const auto& at = count.at[i];
      fmt::print("| {} | {} to {} | {:.0f} % | {} | {} | {} | {} | {:.0f} % |\n", population.name,
                 before, before + runs - 1, 100 * kAskedAt[i], at.asked, at.inside, at.early,
                 at.late, 100 * at.width_share / at.asked);
    }
    fmt::print(stderr, "{}: {:.2f} rereads a row, runs of {:.2f} to {:.2f} h\n", population.name,
               count.rereads_per_row / count.runs, count.shortest_run_h, count.longest_run_h);
  }
}
