#include "server/application/models/fit_options.h"

#include <fmt/format.h>

#include <chrono>

#include "server/application/plumbing/fit_threads.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/formula/formula.h"
#include "server/formats/model/model_json.h"
#include "server/formats/text/row_ranges.h"
#include "server/formats/text/text.h"

namespace driftwise::application {
namespace {

Result<void> parse_terms(const std::vector<std::string>& texts, const Dataset& dataset,
                         std::vector<effects::Term>& out) {
  for (const auto& text : texts) {
    DRIFTWISE_TRY(auto term, formats::parse_term(text, dataset));
    out.push_back(std::move(term));
  }
  return {};
}

}  // namespace

Result<calibration::FitOptions> fit_options_from(const FitRequest& request, const Dataset& dataset,
                                                 const std::string& source) {
  calibration::FitOptions options;
  if (request.select == "all")
    options.select = calibration::Select::all;
  else if (request.select != "stepwise")
    return fail(ErrorCode::invalid_argument, reasons::kBadOptions,
                fmt::format("select = '{}', expected 'stepwise' or 'all'", request.select));
  const auto criterion = calibration::criterion_named(request.criterion);
  if (!criterion)
    return fail(ErrorCode::invalid_argument, reasons::kBadOptions,
                fmt::format("criterion = '{}', expected 'p', 'bic' or 'aic'", request.criterion));
  options.criterion = *criterion;
  options.p_enter = request.p_enter;
  options.p_remove = request.p_remove;
  options.hierarchy = request.hierarchy;
  options.starts = request.starts;
  options.seed = request.seed;
  DRIFTWISE_RETURN_IF_ERROR(parse_terms(request.force_terms, dataset, options.forced));
  DRIFTWISE_RETURN_IF_ERROR(parse_terms(request.without_terms, dataset, options.excluded));
  options.exclude_channels = request.exclude_channels;
  options.weight_symbol = request.weight_symbol;
  options.first_rows = request.first_rows;
  options.set_names = request.set_names;
  options.blocks = request.blocks;
  options.executor = fit_threads(request.threads);
  options.stopwatch_us = [] {
    return std::chrono::duration<double, std::micro>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
  };
  options.lineage.runs = request.runs;
  options.lineage.source = source;
  options.lineage.parent = request.parent;
  options.lineage.dataset_hash = formats::content_hash(formats::write_dataset_csv(dataset));
  options.lineage.exclusions_hash = formats::exclusions_hash(dataset);
  return options;
}

Result<ModelRecord> fit_record(const Dataset& dataset, const FitRequest& request,
                               const std::string& source) {
  DRIFTWISE_TRY(auto options, fit_options_from(request, dataset, source));
  DRIFTWISE_TRY(auto model, formats::fit_formula(dataset, request.formula, std::move(options)));
  ModelRecord record;
  record.name = request.name.empty() ? model.formula : request.name;
  record.note = request.note;
  record.json = formats::write_model_json(model);
  record.hash = formats::model_hash(model);
  record.parent = model.lineage.parent;
  return record;
}

std::string source_of(const FitRequest& request) {
  if (request.runs.empty()) return "dataset";
  std::string text = request.runs.size() == 1 ? "run " : "runs ";
  for (std::size_t i = 0; i < request.runs.size(); ++i)
    text += (i == 0 ? "" : ", ") + std::to_string(request.runs[i].value);
  return text;
}

}  // namespace driftwise::application
