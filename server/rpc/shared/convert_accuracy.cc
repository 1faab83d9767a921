#include "server/rpc/shared/convert_accuracy.h"

namespace driftwise::rpc {

v1::ErrorFigures figures_from(const ErrorFigures& figures) {
  v1::ErrorFigures out;
  out.set_mean(figures.mean);
  out.set_u90(figures.u90);
  out.set_a90(figures.a90);
  out.set_row_count(figures.rows);
  return out;
}

v1::JudgedAccuracy judged_from(const JudgedAccuracy& judged) {
  v1::JudgedAccuracy out;
  out.set_output(judged.output);
  out.set_unit(judged.unit);
  out.set_rows(std::string(to_string(judged.rows)));
  *out.mutable_figures() = figures_from(judged.figures);
  if (judged.before) *out.mutable_before() = figures_from(*judged.before);
  return out;
}

}  // namespace driftwise::rpc
