#include "server/diagnosis/report/taken_by_time.h"

#include <algorithm>
#include <cmath>

#include "server/core/text/quantity_text.h"
#include "server/core/units.h"
#include "server/diagnosis/report/sentence.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kMostOfIt = 0.8, kWhiteAtMost = 0.5;

bool any_acts_on(const Diagnosis& diagnosis, const std::string& output) {
  return std::ranges::any_of(diagnosis.findings, [&](const Finding& finding) {
    return std::ranges::any_of(finding.outputs, [&](const FindingOutput& one) {
      return one.output == output && one.shown;
    });
  });
}

}  // namespace

std::vector<std::string> taken_by_time(const Diagnosis& diagnosis) {
  std::vector<std::string> sentences;
  for (const auto& output : diagnosis.outputs) {
    const auto time = std::ranges::find(output.explained_by, "time", &Share::variable);
    const double share = time == output.explained_by.end() ? 0 : time->share;
    const double white = kSigmaToU90 * output.noise_white_sd;
    if (share < kMostOfIt || !(white < kWhiteAtMost * output.a90_calibration_after)) continue;
    if (any_acts_on(diagnosis, output.output)) continue;
    sentences.push_back(digits_text(std::floor(100 * share)) + " % of what is left of " +
                        output.output + " goes smoothly with the time: A90 " +
                        size_text(output.a90_calibration_after, output.unit) +
                        ", of the white noise alone " + size_text(white, output.unit) +
                        ". Slow noise, a drift and heat that no thermometer shows look alike over "
                        "so short a time; a "
                        "run of at least twice the time would tell");
  }
  return sentences;
}

}  // namespace driftwise::diagnosis
