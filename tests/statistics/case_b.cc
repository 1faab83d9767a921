// case_b: the models of case B beside two oracles that look at the plant, over many machines, and
// where each model's error comes from. docs/evidence/case-b.md has its figures.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/statistics/case_b_models.h"

int main(int argc, char** argv) {
  using namespace driftwise::statistics;
  CLI::App app{
      "Case B on many simulated machines, beside oracles that know the plant.\n"
      "  case_b --first-seed 1001 --seeds 50\n  case_b --formula 'q ~ poly(x, y, z, 3) + T' --bic"};
  std::uint64_t first = 1;
  int seeds = 10;
  bool bic = false;
  std::vector<std::string> formulas;
  app.add_option("--first-seed", first)->capture_default_str();
  app.add_option("--seeds", seeds)->check(CLI::Range(1, 100000))->capture_default_str();
  app.add_option("--formula", formulas, "instead of the models of the table")
      ->allow_extra_args(false);
  app.add_flag("--bic", bic, "select by BIC");
  CLI11_PARSE(app, argc, argv);
  auto models = case_b_models();
  if (!formulas.empty()) models.clear();
  for (const auto& formula : formulas)
    models.push_back({"formula " + std::to_string(models.size() + 1), formula});
  for (auto& model : models) model.bic |= bic;
  try {
    std::vector<CaseBSeed> all;
    for (int s = 0; s < seeds; ++s) {
      all.push_back(case_b_seed(first + static_cast<std::uint64_t>(s), models));
      std::fprintf(stderr, "\r%d of %d", s + 1, seeds);
    }
    std::fprintf(stderr, "\n");
    std::printf("%s", case_b_table(all, models).c_str());
    return 0;
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "\n%s\n", problem.what());
    return 3;
  }
}
