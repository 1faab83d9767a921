#include "server/core/data/accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/core/text/quantity_text.h"
#include "server/core/units.h"

namespace driftwise {
namespace {

constexpr std::array kRows = {JudgedRows::validation, JudgedRows::blocks, JudgedRows::calibration,
                              JudgedRows::fresh};

}  // namespace

ErrorSums& ErrorSums::operator+=(const ErrorSums& other) {
  rows += other.rows;
  sum += other.sum;
  squares += other.squares;
  return *this;
}

ErrorSums ErrorSums::operator-(const ErrorSums& other) const {
  return {rows - other.rows, sum - other.sum, squares - other.squares};
}

ErrorFigures error_figures(const ErrorSums& sums) {
  ErrorFigures figures;
  figures.rows = std::llround(sums.rows);
  if (figures.rows < 1) return figures;
  figures.mean = sums.sum / sums.rows;
  figures.a90 = kSigmaToU90 * std::sqrt(std::max(0.0, sums.squares) / sums.rows);
  if (figures.rows > 1)
    figures.u90 = kSigmaToU90 * std::sqrt(std::max(0.0, sums.squares - sums.sum * figures.mean) /
                                          (sums.rows - 1));
  return figures;
}

ErrorFigures error_figures(std::span<const double> errors) {
  ErrorFigures figures;
  double sum = 0;
  for (const double error : errors)
    if (std::isfinite(error)) sum += error, ++figures.rows;
  if (figures.rows == 0) return figures;
  const auto n = static_cast<double>(figures.rows);
  figures.mean = sum / n;
  double about_mean = 0, squares = 0;
  for (const double error : errors) {
    if (!std::isfinite(error)) continue;
    about_mean += (error - figures.mean) * (error - figures.mean);
    squares += error * error;
  }
  figures.a90 = kSigmaToU90 * std::sqrt(squares / n);
  if (figures.rows > 1) figures.u90 = kSigmaToU90 * std::sqrt(about_mean / (n - 1));
  return figures;
}

std::string_view to_string(JudgedRows rows) {
  switch (rows) {
    case JudgedRows::validation:
      return "validation";
    case JudgedRows::blocks:
      return "blocks";
    case JudgedRows::calibration:
      return "calibration";
    case JudgedRows::fresh:
      return "fresh";
  }
  return "";
}

std::optional<JudgedRows> judged_rows_from(std::string_view text) {
  for (const JudgedRows rows : kRows)
    if (to_string(rows) == text) return rows;
  return std::nullopt;
}

std::string_view in_words(JudgedRows rows) {
  switch (rows) {
    case JudgedRows::validation:
      return "validation rows";
    case JudgedRows::blocks:
      return "held-out blocks of time";
    case JudgedRows::calibration:
      return "the fit's own rows, none held out";
    case JudgedRows::fresh:
      return "fresh points";
  }
  return "";
}

std::vector<JudgedAccuracy> heading_of(std::span<const JudgedAccuracy> judged) {
  std::vector<JudgedAccuracy> heading;
  for (const auto& one : judged) {
    const auto at = std::ranges::find(heading, one.unit, &JudgedAccuracy::unit);
    if (at == heading.end()) {
      heading.push_back(one);
      continue;
    }
    const bool held_out = one.rows != JudgedRows::calibration,
               shown_held_out = at->rows != JudgedRows::calibration;
    if (held_out == shown_held_out ? one.figures.a90 > at->figures.a90 : held_out) *at = one;
  }
  return heading;
}

std::string accuracy_text(const JudgedAccuracy& accuracy) {
  const std::string unit = accuracy.unit == "1" ? "" : " " + accuracy.unit;
  const std::string before =
      accuracy.before ? digits_text(accuracy.before->a90) + " -> " : std::string();
  return before + digits_text(accuracy.figures.a90) + unit + " (" + accuracy.output + ", " +
         std::string(in_words(accuracy.rows)) + ", mean " +
         mean_text(accuracy.figures.mean, accuracy.figures.a90) + unit + ", S90 " +
         digits_text(accuracy.figures.u90) + unit + ")";
}

}  // namespace driftwise
