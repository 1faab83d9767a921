#include "server/core/devices/loop_tuning.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace driftwise {
namespace {

struct TuningPart {
  const char *name, *unit;
  std::optional<double> LoopTuning::*value;
};
constexpr std::array kParts{TuningPart{"heat band", "K", &LoopTuning::heat_band_k},
                            TuningPart{"cool band", "K", &LoopTuning::cool_band_k},
                            TuningPart{"integral", "s", &LoopTuning::integral_s},
                            TuningPart{"derivative", "s", &LoopTuning::derivative_s}};

std::string part_text(const TuningPart& part, double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%s %.6g %s", part.name, value, part.unit);
  return text;
}

}  // namespace

std::string tuning_text(const LoopTuning& tuning) {
  std::string text;
  for (const auto& part : kParts)
    if (const auto& value = tuning.*part.value)
      text += (text.empty() ? "" : ", ") + part_text(part, *value);
  return text;
}

std::vector<std::string> differences_of(const LoopTuning& declared, const LoopTuning& found) {
  constexpr double kShare = 1e-3, kTime_s = 0.1;
  std::vector<std::string> out;
  for (const auto& part : kParts) {
    const auto &wanted = declared.*part.value, &is = found.*part.value;
    if (!wanted) continue;
    const double room = part.unit[0] == 's' ? kTime_s : kShare * std::abs(*wanted);
    if (is && std::abs(*is - *wanted) <= room) continue;
    out.push_back("the cell file declares " + part_text(part, *wanted) + ", the controller has " +
                  (is ? part_text(part, *is) : std::string("none")));
  }
  return out;
}

LoopTuning changed(LoopTuning tuning, const LoopTuning& with) {
  for (const auto& part : kParts)
    if (with.*part.value) tuning.*part.value = with.*part.value;
  return tuning;
}

}  // namespace driftwise
