#include "server/application/diagnoses/diagnoses_service.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/models/model_integrity.h"
#include "server/application/plumbing/run_on.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/diagnosis/stored_diagnosis.h"
#include "server/formats/formula/formula.h"
#include "server/formats/text/text.h"

namespace driftwise::application {
namespace {

constexpr int kListedDiagnoses = 500;

// The request as the record keeps it. A file is identified by its hash.
std::string request_json(const DiagnosisRequest& request) {
  nlohmann::ordered_json json{{"baseline", request.baseline},
                              {"alpha", request.alpha},
                              {"seed", request.seed},
                              {"exclude_symbols", request.exclude_symbols}};
  if (!request.csv.empty()) json["dataset_hash"] = formats::content_hash(request.csv);
  return json.dump();
}

// On the query thread: a diagnosis with long curves is a few hundred kilobytes of JSON.
Result<DiagnosisView> view_of(Store& store, DiagnosisRecord record) {
  DiagnosisView view;
  if (!record.result_json.empty()) {
    DRIFTWISE_TRY(auto found, formats::read_stored_diagnosis(record.result_json));
    view.found = std::move(found);
  }
  DRIFTWISE_TRY(auto extension, store.extensions().extension(record.id));
  view.extension = std::move(extension);
  view.record = std::move(record);
  return view;
}

// Checks before the search begins: the formula against the data, and time.
Result<diagnosis::DiagnoseOptions> options_for(const Dataset& dataset,
                                               const DiagnosisRequest& request) {
  DRIFTWISE_TRY(auto formula, formats::Formula::parse(request.baseline));
  DRIFTWISE_TRY(auto candidates, formula.expand(dataset));
  for (std::size_t row = 1; row < dataset.time_s.size(); ++row)
    if (dataset.time_s[row] < dataset.time_s[row - 1])
      return fail(ErrorCode::invalid_argument, reasons::kTimeRunsBack,
                  fmt::format("row {} is at {:g} s, the row before it at {:g} s: a diagnosis needs "
                              "the rows in time order",
                              row + 1, dataset.time_s[row], dataset.time_s[row - 1]));
  diagnosis::DiagnoseOptions options;
  options.baseline = std::move(candidates);
  options.alpha = request.alpha;
  options.seed = static_cast<std::uint64_t>(request.seed);
  options.exclude_symbols = request.exclude_symbols;
  return options;
}

}  // namespace

// A baseline that is not given is that of the model it begins from.
Awaitable<Result<void>> DiagnosesService::resolve_baseline(DiagnosisRequest& request) {
  if (request.model || request.baseline.empty()) {
    if (!request.model) request.model = serving_.model();
    if (!request.model)
      co_return fail(ErrorCode::failed_precondition, reasons::kNoModel,
                     "no baseline is given and no model serves: give a formula, or a model");
    DRIFTWISE_CO_TRY(const auto record, co_await models_.get(*request.model));
    if (request.baseline.empty()) {
      DRIFTWISE_CO_TRY(const auto from, read_formula_model(record, "diagnoses are made"));
      request.baseline = from.formula;
    }
  }
  co_return Result<void>{};
}

Awaitable<Result<DiagnosisView>> DiagnosesService::create(Caller caller, DiagnosisRequest request) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await resolve_baseline(request));
  DRIFTWISE_CO_TRY(auto dataset, co_await datasets_.load(request.runs, request.csv));
  const auto shared = std::make_shared<const Dataset>(std::move(dataset));
  DRIFTWISE_CO_TRY(auto options,
                   co_await run_on(
                       background_,
                       [](const std::shared_ptr<const Dataset>& data,
                          const DiagnosisRequest& asked) { return options_for(*data, asked); },
                       shared, request));
  if (request.csv.empty()) options.levers = diagnosis::declared_lever_limits(description_);
  DiagnosisRecord fresh;
  fresh.name = request.name;
  fresh.runs = request.runs;
  fresh.model = request.model;
  fresh.baseline = options.baseline.formula;
  fresh.request_json = request_json(request);
  auto beginning = desk_.begin(caller, std::move(fresh), shared, std::move(options));
  DRIFTWISE_CO_TRY(auto stored, co_await std::move(beginning));
  co_return DiagnosisView{std::move(stored), std::nullopt, std::nullopt};
}

Awaitable<Result<DiagnosisView>> DiagnosesService::get(DiagnosisId id) {
  co_return co_await reader_.call([id](Store& store) -> Result<DiagnosisView> {
    DRIFTWISE_TRY(auto record, store.diagnoses().diagnosis(id));
    return view_of(store, std::move(record));
  });
}

Awaitable<Result<std::vector<DiagnosisView>>> DiagnosesService::list() {
  co_return co_await reader_.call([](Store& store) -> Result<std::vector<DiagnosisView>> {
    DRIFTWISE_TRY(auto records, store.diagnoses().diagnoses(kListedDiagnoses));
    std::vector<DiagnosisView> views;
    for (auto& record : records) {
      DRIFTWISE_TRY(auto view, view_of(store, std::move(record)));
      views.push_back(std::move(view));
    }
    return views;
  });
}

Awaitable<Result<DiagnosisView>> DiagnosesService::cancel(Caller caller, DiagnosisId id) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await desk_.cancel(caller, id));
  co_return co_await get(id);
}

std::shared_ptr<void> DiagnosesService::watch(
    std::function<void(const DiagnosisProgress&)> on_change) {
  desk_.tell_present(on_change);
  return desk_.watchers().add(std::move(on_change));
}

}  // namespace driftwise::application
