#include "server/rpc/fit_request.h"

#include "server/rpc/request_checks.h"

namespace driftwise::rpc {
namespace {

Result<void> check_probabilities(const application::FitRequest& fit) {
  const auto inside = [](double p) { return p > 0.0 && p < 1.0; };  // false for NaN
  if (inside(fit.p_enter) && inside(fit.p_remove) && fit.p_remove >= fit.p_enter) return {};
  return fail(ErrorCode::invalid_argument, "BAD_PROBABILITY",
              "found p_enter " + std::to_string(fit.p_enter) + " and p_remove " +
                  std::to_string(fit.p_remove) + ", expected 0 < p_enter <= p_remove < 1");
}

}  // namespace

Result<application::FitRequest> fit_request_from(const v1::CreateFitRequest& request) {
  for (const auto& good : {check_size(request.csv(), kMostDatasetBytes, "csv"),
                           check_size(request.formula(), kMostFormulaBytes, "formula"),
                           check_size(request.name(), kMostNameBytes, "name"),
                           check_size(request.note(), kMostNoteBytes, "note"),
                           check_cursor(request.first_rows(), "first_rows")})
    if (!good) return tl::unexpected(good.error());
  if (request.csv().empty() == request.run_ids().empty())
    return fail(ErrorCode::invalid_argument, "RUNS_OR_CSV",
                std::string("found ") +
                    (request.csv().empty() ? "neither run_ids nor csv" : "run_ids and csv") +
                    ", expected one of them");
  if (request.formula().empty())
    return fail(ErrorCode::invalid_argument, "EMPTY_FORMULA",
                "formula: found nothing, expected something like q ~ x + x^2 + T");
  application::FitRequest fit;
  auto runs = run_ids_from(request.run_ids());
  if (!runs) return tl::unexpected(runs.error());
  fit.runs = std::move(*runs);
  fit.csv = request.csv();
  fit.formula = request.formula();
  if (!request.select().empty()) fit.select = request.select();
  if (fit.select != "stepwise" && fit.select != "all")
    return fail(ErrorCode::invalid_argument, "BAD_SELECT",
                "select: found '" + fit.select + "', expected 'stepwise' or 'all'");
  if (request.has_p_enter()) fit.p_enter = request.p_enter();
  if (request.has_p_remove()) fit.p_remove = request.p_remove();
  if (auto good = check_probabilities(fit); !good) return tl::unexpected(good.error());
  fit.name = request.name();
  fit.note = request.note();
  fit.exclude_channels.assign(request.exclude_symbols().begin(), request.exclude_symbols().end());
  fit.first_rows = request.first_rows();
  return fit;
}

}  // namespace driftwise::rpc
