#include "server/diagnosis/report/heading.h"

#include "server/core/text/quantity_text.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kWorse = 1.05;  // below this a change of A90 is within its own uncertainty

}  // namespace

std::vector<JudgedAccuracy> judged_accuracies(const Diagnosis& diagnosis) {
  std::vector<JudgedAccuracy> judged;
  const auto held_out = static_cast<std::int64_t>(diagnosis.rows_held_out);
  const auto calibration = static_cast<std::int64_t>(diagnosis.rows_calibration);
  for (const auto& output : diagnosis.outputs) {
    if (output.a90_validation_before && output.a90_validation_after)
      judged.push_back(
          {output.output,
           output.unit,
           diagnosis.judged_on,
           {held_out, output.mean_validation_after.value_or(0),
            output.u90_validation_after.value_or(0), *output.a90_validation_after},
           ErrorFigures{held_out, output.mean_validation_before.value_or(0),
                        output.u90_validation_before.value_or(0), *output.a90_validation_before}});
    else
      judged.push_back(
          {output.output,
           output.unit,
           JudgedRows::calibration,
           {calibration, output.mean_calibration_after, output.u90_calibration_after,
            output.a90_calibration_after},
           ErrorFigures{calibration, output.mean_calibration_before, output.u90_calibration_before,
                        output.a90_calibration_before}});
  }
  return judged;
}

std::vector<JudgedAccuracy> heading_of(const Diagnosis& diagnosis) {
  return driftwise::heading_of(judged_accuracies(diagnosis));
}

std::vector<std::string> outputs_made_worse(const Diagnosis& diagnosis) {
  std::vector<std::string> worse;
  for (const auto& one : judged_accuracies(diagnosis))
    if (one.rows != JudgedRows::calibration && one.figures.a90 > kWorse * one.before->a90)
      worse.push_back(one.output + ": " + digits_text(one.before->a90) + " -> " +
                      digits_text(one.figures.a90) + " " + one.unit);
  return worse;
}

}  // namespace driftwise::diagnosis
