// plant_sweep [NAME [SEEDS [NULLS [FIRST_SEED]]]]: hides each case of plant_cases.h whose name
// begins with NAME in a plant, SEEDS times, and prints the table of docs/diagnosis-plants.md.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "tests/hidden_effects/plant_cases.h"

int main(int count, char** arguments) {
  using namespace driftwise;
  const std::string prefix = count > 1 ? arguments[1] : "";
  const int seeds = count > 2 ? std::atoi(arguments[2]) : 3;
  const int nulls = count > 3 ? std::atoi(arguments[3]) : 99;
  const int first = count > 4 ? std::atoi(arguments[4]) : 1;
  std::printf(
      "| case | hidden as | exact | exact or in set | wrong | U90 before, after, known nm | "
      "named |\n|---|---|---|---|---|---|---|\n");
  for (const auto& one : hidden::plant_cases()) {
    if (!one.name.starts_with(prefix)) continue;
    int exact = 0, in_set = 0, wrong = 0;
    double before = 0, after = 0, known = 0, seconds = 0;
    std::map<std::string, int> named;
    for (int k = 0; k < seeds; ++k) {
      const auto run = hidden::run_case(one, static_cast<std::uint64_t>(first + k));
      const auto begin = std::chrono::steady_clock::now();
      const auto verdict =
          hidden::judged_by_truth(one, run, hidden::diagnosed_case(one, run.data, nulls));
      seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      exact += verdict.exact;
      in_set += verdict.in_set;
      wrong += verdict.wrong;
      before += verdict.u90_before / seeds;
      after += verdict.u90_after / seeds;
      known += verdict.u90_known / seeds;
      ++named[verdict.named.empty() ? "nothing" : verdict.named];
    }
    std::printf("| %s | %s | %d/%d | %d/%d | %d/%d | %.1f, %.1f, %.1f |", one.name.c_str(),
                one.cause.empty() ? "nothing" : one.cause.c_str(), exact, seeds, in_set, seeds,
                wrong, seeds, before, after, known);
    for (const auto& [name, times] : named)
      std::printf(" %s%s%s", name.c_str(), times > 1 ? " x" : "",
                  times > 1 ? std::to_string(times).c_str() : "");
    std::printf(" |\n");
    std::fprintf(stderr, "%s: %.2f s per diagnosis\n", one.name.c_str(), seconds / seeds);
    std::fflush(stdout);
  }
}
