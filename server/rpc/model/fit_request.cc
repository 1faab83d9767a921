#include "server/rpc/model/fit_request.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/text/text.h"
#include "server/rpc/shared/request_checks.h"

namespace driftwise::rpc {
namespace {

Result<void> check_probabilities(const application::FitRequest& fit) {
  const auto inside = [](double p) { return p > 0.0 && p < 1.0; };  // false for NaN
  if (inside(fit.p_enter) && inside(fit.p_remove) && fit.p_remove >= fit.p_enter) return {};
  return fail(ErrorCode::invalid_argument, reasons::kBadProbability,
              "found p_enter " + formats::number_text(fit.p_enter) + " and p_remove " +
                  formats::number_text(fit.p_remove) + ", expected 0 < p_enter <= p_remove < 1");
}

// What the fit of a file has as options: ranges as there.
Result<void> read_selection(const v1::CreateFitRequest& request, application::FitRequest& fit) {
  constexpr int kMostStarts = 10'000, kMostBlocks = 1000, kMostTerms = 1000, kMostThreads = 1024;
  const auto bad = [](const std::string& field, auto found, const std::string& expected) {
    return fail(ErrorCode::invalid_argument, reasons::kBadOption,
                field + ": found " + std::to_string(found) + ", expected " + expected);
  };
  if (!request.criterion().empty()) fit.criterion = request.criterion();
  if (fit.criterion != "p" && fit.criterion != "bic" && fit.criterion != "aic")
    return fail(
        ErrorCode::invalid_argument, reasons::kBadCriterion,
        "criterion: found '" + fit.criterion.substr(0, 40) + "', expected 'p', 'bic' or 'aic'");
  fit.hierarchy = request.hierarchy();
  if (request.start_count() < 0 || request.start_count() > kMostStarts)
    return bad("start_count", request.start_count(), "0 (meaning 1) to 10000");
  fit.starts = request.start_count() == 0 ? 1 : request.start_count();
  if (request.has_seed()) fit.seed = request.seed();
  if (fit.seed < 0) return bad("seed", fit.seed, "a number from 0");
  if (request.has_block_count()) fit.blocks = request.block_count();
  if (fit.blocks < 0 || fit.blocks > kMostBlocks)
    return bad("block_count", fit.blocks, "0 to 1000");
  if (request.force_terms_size() > kMostTerms || request.without_terms_size() > kMostTerms)
    return bad("force_terms, without_terms",
               std::max(request.force_terms_size(), request.without_terms_size()),
               "at most 1000 terms");
  for (const auto* terms : {&request.force_terms(), &request.without_terms()})
    for (const auto& term : *terms)
      if (auto good = check_size(term, kMostFormulaBytes, "force_terms, without_terms"); !good)
        return good;
  fit.force_terms.assign(request.force_terms().begin(), request.force_terms().end());
  fit.without_terms.assign(request.without_terms().begin(), request.without_terms().end());
  fit.weight_symbol = request.weight_symbol();
  fit.threads = request.thread_count();
  if (fit.threads < 0 || fit.threads > kMostThreads)
    return bad("thread_count", fit.threads, "0 to 1024");
  return {};
}

}  // namespace

Result<application::FitRequest> fit_request_from(const v1::CreateFitRequest& request,
                                                 FormulaIs formula, DataIs data) {
  for (const auto& good : {check_size(request.csv(), kMostDatasetBytes, "csv"),
                           check_size(request.formula(), kMostFormulaBytes, "formula"),
                           check_size(request.name(), kMostNameBytes, "name"),
                           check_size(request.note(), kMostNoteBytes, "note"),
                           check_cursor(request.first_rows(), "first_rows")})
    DRIFTWISE_RETURN_IF_ERROR(good);
  const bool any_data = !request.csv().empty() || !request.run_ids().empty();
  if (request.csv().empty() == request.run_ids().empty() && (any_data || data == DataIs::required))
    return fail(ErrorCode::invalid_argument, reasons::kRunsOrCsv,
                std::string("found ") +
                    (request.csv().empty() ? "neither run_ids nor csv" : "run_ids and csv") +
                    ", expected one of them");
  if (request.formula().empty() && formula == FormulaIs::required)
    return fail(ErrorCode::invalid_argument, reasons::kEmptyFormula,
                "formula: found nothing, expected something like q ~ x + x^2 + T");
  application::FitRequest fit;
  DRIFTWISE_TRY(auto runs, run_ids_from(request.run_ids()));
  fit.runs = std::move(runs);
  fit.csv = request.csv();
  fit.formula = request.formula();
  if (!request.select().empty()) fit.select = request.select();
  if (fit.select != "stepwise" && fit.select != "all")
    return fail(ErrorCode::invalid_argument, reasons::kBadSelect,
                "select: found '" + fit.select + "', expected 'stepwise' or 'all'");
  if (request.has_p_enter()) fit.p_enter = request.p_enter();
  if (request.has_p_remove()) fit.p_remove = request.p_remove();
  DRIFTWISE_RETURN_IF_ERROR(check_probabilities(fit));
  fit.name = clean_line(request.name());
  fit.note = clean_text(request.note());
  fit.exclude_channels.assign(request.exclude_symbols().begin(), request.exclude_symbols().end());
  fit.first_rows = request.first_rows();
  DRIFTWISE_RETURN_IF_ERROR(read_selection(request, fit));
  return fit;
}

Result<application::KinematicRequest> kinematic_request_from(
    const v1::CreateKinematicModelRequest& request) {
  DRIFTWISE_RETURN_IF_ERROR(check_size(request.robot_toml(), kMostRobotBytes, "robot_toml"));
  application::KinematicRequest asked;
  DRIFTWISE_TRY(asked.fit, fit_request_from(request.fit(), FormulaIs::optional, DataIs::optional));
  asked.robot = request.robot_toml();
  asked.joint_errors = request.with_joint_errors();
  return asked;
}

}  // namespace driftwise::rpc
