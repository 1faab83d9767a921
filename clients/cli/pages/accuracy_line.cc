#include "clients/cli/pages/accuracy_line.h"

namespace driftwise::cli {

ErrorFigures figures_of(const v1::ErrorFigures& figures) {
  return {.rows = figures.row_count(),
          .mean = figures.mean(),
          .u90 = figures.u90(),
          .a90 = figures.a90()};
}

std::string accuracy_text(const v1::JudgedAccuracy& judged) {
  JudgedAccuracy one{judged.output(), judged.unit(),
                     judged_rows_from(judged.rows()).value_or(JudgedRows::calibration),
                     figures_of(judged.figures()), std::nullopt};
  if (judged.has_before()) one.before = figures_of(judged.before());
  return driftwise::accuracy_text(one);
}

}  // namespace driftwise::cli
