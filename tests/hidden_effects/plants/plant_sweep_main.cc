// plant_sweep [NAME [SEEDS [NULLS [FIRST_SEED]]]]: hides each case of plant_cases.h whose name
// begins with NAME in a plant, SEEDS times, and prints the table of docs/diagnosis-plants.md.

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "server/formats/csv/dataset_csv.h"
#include "tests/hidden_effects/plants/plant_cases.h"

namespace {

using namespace driftwise;

struct Options {
  std::string prefix, baseline, folder;
  int seeds = 3, nulls = 99;
  std::uint64_t first = 1;
  std::vector<std::string> overrides;
};

void keep(const Options& options, const hidden::PlantCase& one, std::uint64_t seed,
          const Dataset& data) {
  std::ofstream(std::filesystem::path(options.folder) /
                (one.name + "." + std::to_string(seed) + ".csv"))
      << formats::write_dataset_csv(data);
}

std::string one_decimal(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", value);
  return text.data();
}

void print_row(const hidden::PlantCase& one, const Options& options) {
  int exact = 0, in_set = 0, wrong = 0;
  double before = 0, after = 0, known = 0, seconds = 0, left = 0;
  int in_step = 0;
  std::map<std::string, int> named;
  for (int k = 0; k < options.seeds; ++k) {
    const std::uint64_t seed = options.first + static_cast<std::uint64_t>(k);
    const auto run = hidden::run_case(one, seed);
    if (!options.folder.empty()) keep(options, one, seed, run.data);
    if (const auto nm = hidden::left_to_find_nm(one, run, seed)) {
      left += *nm;
      ++in_step;
    }
    const auto begin = std::chrono::steady_clock::now();
    const auto verdict =
        hidden::judged_by_truth(one, run, hidden::diagnosed_case(one, run.data, options.nulls));
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    exact += verdict.exact;
    in_set += verdict.in_set;
    wrong += verdict.wrong;
    before += verdict.u90_before / options.seeds;
    after += verdict.u90_after / options.seeds;
    known += verdict.u90_known / options.seeds;
    ++named[verdict.named.empty() ? "nothing" : verdict.named];
  }
  std::printf("| %s | %s | %d/%d | %d/%d | %d/%d | %s | %.1f, %.1f, %.1f |", one.name.c_str(),
              one.cause.empty() ? "nothing" : one.cause.c_str(), exact, options.seeds, in_set,
              options.seeds, wrong, options.seeds,
              in_step > 0 ? one_decimal(left / in_step).c_str() : "", before, after, known);
  const char* between = " ";
  for (const auto& [name, times] : named) {
    std::printf("%s%s%s", between, name.c_str(),
                times > 1 ? (" x" + std::to_string(times)).c_str() : "");
    between = "; ";
  }
  std::printf(" |\n");
  std::fprintf(stderr, "%s: %.2f s per diagnosis\n", one.name.c_str(), seconds / options.seeds);
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** arguments) {
  CLI::App app("Hides mechanisms in the plants and prints what a diagnosis names.");
  Options options;
  app.add_option("name", options.prefix, "what the case's name begins with: axis., micro.lag");
  app.add_option("seeds", options.seeds, "plants per case")->capture_default_str();
  app.add_option("nulls", options.nulls, "of each diagnosis")->capture_default_str();
  app.add_option("first", options.first, "seed of the first plant")->capture_default_str();
  app.add_option("--baseline", options.baseline, "formula instead of the case's own");
  app.add_option("--set", options.overrides, "over the plant file, section.key=value");
  app.add_option("--keep", options.folder, "folder that gets every data set as CSV")
      ->check(CLI::ExistingDirectory);
  CLI11_PARSE(app, count, arguments);

  std::printf(
      "| case | hidden as | exact | exact or in set | wrong | to be found nm | S90 before, after, "
      "known nm | named |\n|---|---|---|---|---|---|---|---|\n");
  for (auto one : hidden::plant_cases()) {
    if (!one.name.starts_with(options.prefix)) continue;
    if (!options.baseline.empty()) one.baseline = options.baseline;
    one.overrides.insert(one.overrides.end(), options.overrides.begin(), options.overrides.end());
    print_row(one, options);
  }
}
