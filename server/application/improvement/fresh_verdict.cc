#include "server/application/improvement/fresh_verdict.h"

#include <fmt/format.h>

#include "server/core/text/quantity_text.h"

namespace driftwise::application {

FreshVerdict judge_fresh(const std::vector<TurnGain>& gains) {
  constexpr double kSame = 1.05;  // a twentieth: what a refit moves by itself
  FreshVerdict verdict;
  for (const auto& gain : gains) {
    if (!gain.measured || !gain.measured_before) continue;
    verdict.judged = true;
    const double before = gain.measured_before->a90, after = gain.measured->a90;
    const std::string change =
        fmt::format("{} {} -> {} {} (mean {} -> {})", gain.output, digits_text(before),
                    digits_text(after), gain.unit, mean_text(gain.measured_before->mean, before),
                    mean_text(gain.measured->mean, after));
    verdict.better |= after * kSame < before;
    if (after > kSame * before) verdict.worse += (verdict.worse.empty() ? "" : ", ") + change;
    verdict.measured += (verdict.measured.empty() ? "" : ", ") + change;
  }
  return verdict;
}

std::optional<ErrorFigures> fresh_figures(const ModelCheck& check, const std::string& symbol) {
  for (const auto& output : check.report.outputs)
    if (output.channel.symbol == symbol && !output.points.empty() && output.points[0].rows > 1) {
      const auto& point = output.points[0];
      return ErrorFigures{
          .rows = point.rows, .mean = point.bias, .u90 = point.u90, .a90 = point.a90};
    }
  return std::nullopt;
}

std::string why_unjudged(const ModelCheck& check) {
  for (const auto& output : check.report.outputs)
    if (!output.points.empty() && !output.points[0].why_not.empty())
      return output.points[0].why_not;
  return "fewer than two rows could be judged";
}

}  // namespace driftwise::application
