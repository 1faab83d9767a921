// hidden_effects_sweep CAUSE CHI2 COUNT [AUTOCORRELATION [SEED]]: hides one cause in COUNT data
// sets and says what was named. CAUSE "nothing" hides nothing; "all" goes through every cause.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "server/diagnosis/diagnosis.h"
#include "server/formats/formula.h"
#include "tests/hidden_effects/hidden_world.h"

int main(int count, char** arguments) {
  using namespace driftwise;
  if (count < 4) return 2;
  const std::string asked = arguments[1];
  const double chi2 = std::atof(arguments[2]);
  const int sets = std::atoi(arguments[3]);
  hidden::World world;
  if (count > 4) world.autocorrelation = std::atof(arguments[4]);
  const int first_seed = count > 5 ? std::atoi(arguments[5]) : 1;
  auto causes = hidden::hideable();
  if (asked != "all") {
    hidden::Hidden one{asked == "nothing" ? "" : asked, 0, chi2};
    for (const auto& known : causes)
      if (known.cause == asked) one.parameter = known.parameter;
    causes = {one};
  }
  for (auto& cause : causes) {
    cause.chi2 = chi2;
    int exact = 0, in_set = 0, missed = 0, wrong = 0, unexplained = 0, cover = 0;
    std::map<std::string, int> others;
    const auto begin = std::chrono::steady_clock::now();
    for (int k = 0; k < sets; ++k) {
      const auto made = hidden::make(world, {cause}, static_cast<std::uint64_t>(first_seed + k));
      diagnosis::DiagnoseOptions options;
      options.baseline = *formats::Formula::parse(made.baseline)->expand(made.data);
      const auto found = diagnosis::diagnose(made.data, options);
      if (!found) {
        std::fprintf(stderr, "%s\n", found.error().message.c_str());
        return 1;
      }
      bool named = false, listed = false, other = false;
      for (const auto& finding : found->findings) {
        if (finding.cause == cause.cause) {
          named = true;
          for (const auto& parameter : finding.parameters)
            if (parameter.ci90 && !parameter.curve.empty() &&
                parameter.ci90->low <= cause.parameter && cause.parameter <= parameter.ci90->high)
              ++cover;
          continue;
        }
        bool mentions = false;
        for (const auto& rival : finding.indistinguishable_from)
          mentions |= rival.substr(0, rival.find(' ')) == cause.cause;
        listed |= mentions;
        if (!mentions) {
          other = true;
          ++others[finding.cause + " " + finding.subject];
        }
      }
      exact += named && !other && found->findings.size() == 1;
      in_set += (named || listed) && !other;
      missed += !named && !listed && !other;
      wrong += other;
      unexplained += found->verdict == diagnosis::Verdict::unexplained;
    }
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::printf(
        "%-22s chi2 %5.0f rho %.2f: exact %d, exact or in set %d, missed %d, wrong %d, unexplained "
        "%d, ci %d of %d (%.2f s each)",
        cause.cause.empty() ? "nothing" : cause.cause.c_str(), chi2, world.autocorrelation, exact,
        in_set, missed, wrong, unexplained, cover, sets, seconds / sets);
    for (const auto& [name, times] : others) std::printf(" %s:%d", name.c_str(), times);
    std::printf("\n");
    std::fflush(stdout);
  }
}
