// Coverage of targets whose datum's zero was taken outside the fitted domain (docs/uncertainty.md):
// later_zeros --first-seed 90001 --machines 100 --within --all-terms

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>

#include "tests/statistics/later_zeros/later_zero_case.h"

using namespace driftwise::statistics;

int main(int argc, char** argv) {
  CLI::App app{"Targets after a zero outside the fitted domain, judged by the plant's truth"};
  std::uint64_t first_seed = 90001;
  int machines = 100;
  app.add_option("--first-seed", first_seed);
  app.add_option("--machines", machines);
  LaterRoom room;
  bool all_terms = false;
  app.add_flag("--within", room.stays_within, "the room stays on the campaign's way");
  app.add_flag("--all-terms", all_terms, "fit every term instead of a stepwise selection");
  CLI11_PARSE(app, argc, argv);
  if (all_terms) room.select = driftwise::calibration::Select::all;
  LaterZeroCount count;
  for (int i = 0; i < machines; ++i)
    count.add(later_zeros(first_seed + static_cast<std::uint64_t>(i), room));
  std::fputs(count.table().c_str(), stdout);
  return 0;
}
