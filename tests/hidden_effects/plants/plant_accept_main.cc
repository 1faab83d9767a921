// plant_accept [NAME [SEEDS [NULLS [FIRST_SEED]]]]: hides every cause that applies to the
// correction stage in a plant, accepts what is named, and prints the second table of
// docs/diagnosis-plants.md, and the count of issue 13: plants in which a target became worse by
// more than 5 % and 1 nm, rms at the truth.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/hidden_effects/accepting/served_truth.h"
#include "tests/hidden_effects/plants/plant_accept.h"

int main(int count, char** arguments) {
  using namespace driftwise;
  const std::string prefix = count > 1 ? arguments[1] : "";
  const int seeds = count > 2 ? std::atoi(arguments[2]) : 3;
  const int nulls = count > 3 ? std::atoi(arguments[3]) : 49;
  const int first = count > 4 ? std::atoi(arguments[4]) : 1;
  int made_of = 0, all = 0;
  std::vector<std::string> harmed;
  std::vector<double> ratios;  // of plants with something accepted: all outputs together
  std::printf(
      "| case | named, lengths corrected | S90 at the truth nm: as measured -> accepted (nothing "
      "hidden) | after / before |\n|---|---|---|---|\n");
  for (const auto& one : hidden::instrument_cases()) {
    if (!one.name.starts_with(prefix)) continue;
    std::vector<hidden::AcceptedOnPlant> plants;
    std::printf("| %s |", one.name.c_str());
    for (int k = 0; k < seeds; ++k) {
      const auto& made = plants.emplace_back(
          hidden::accepted_on_plant(one, static_cast<std::uint64_t>(first + k), nulls));
      std::printf("%s %s", k > 0 ? ";" : "", made.named.empty() ? "nothing" : made.named.c_str());
      if (!made.refused.empty()) std::printf(" (not made)");
      for (const auto& axis : made.shifted) std::printf(" [%s]", axis.c_str());
    }
    std::printf(" |");
    for (std::size_t k = 0; k < plants.size(); ++k) {
      ++all;
      if (!plants[k].refused.empty()) continue;
      ++made_of;
      double before = 0, after = 0;
      for (const auto& output : plants[k].outputs) {
        const double was = hidden::rms_of(output.before_nm), is = hidden::rms_of(output.after_nm);
        before += was * was;
        after += is * is;
        if (!hidden::is_harmed(was, is)) continue;
        harmed.push_back(one.name + " seed " + std::to_string(first + static_cast<int>(k)) + " " +
                         output.output + ": " + std::to_string(was) + " -> " + std::to_string(is) +
                         " nm rms, " + plants[k].named);
      }
      ratios.push_back(std::sqrt(after / before));
    }
    for (const auto& made : plants)
      for (const auto& output : made.outputs)
        std::printf(" %s %.1f -> %.1f (%.1f)", output.output.c_str(),
                    hidden::u90_at_truth(output.before_nm), hidden::u90_at_truth(output.after_nm),
                    hidden::u90_at_truth(output.nothing_hidden_nm));
    std::printf(" |");
    for (std::size_t o = 0; seeds > 1 && o < plants.front().outputs.size(); ++o) {
      const auto harm = hidden::harm_of(plants, o);
      std::printf(" %s x %.2f, at least %.2f", plants.front().outputs[o].output.c_str(), harm.mean,
                  harm.low);
    }
    std::printf(" |\n");
    std::fflush(stdout);
  }
  std::printf(
      "\n%d plants, %d with something accepted; targets worse by more than 5 %% and 1 nm: %zu\n",
      all, made_of, harmed.size());
  for (const auto& one : harmed) std::printf("  %s\n", one.c_str());
  if (ratios.size() < 2) return 0;
  const auto mean = hidden::mean_ratio(ratios, 0.95);
  std::printf("rms after / before, geometric mean over these plants %.3f (95 %%: %.3f to %.3f)\n",
              mean.mean, mean.low, mean.high);
}
