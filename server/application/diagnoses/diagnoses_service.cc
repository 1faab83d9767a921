#include "server/application/diagnoses/diagnoses_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/datasets/row_names.h"
#include "server/application/models/model_integrity.h"
#include "server/application/plumbing/run_on.h"
#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/diagnosis/robot_names.h"
#include "server/formats/diagnosis/stored_diagnosis.h"
#include "server/formats/formula/formula.h"
#include "server/formats/text/text.h"
#include "server/plans/robot_parts.h"

namespace driftwise::application {
namespace {

constexpr int kListedDiagnoses = 500;

// The request as the record keeps it. A file is identified by its hash.
std::string request_json(const DiagnosisRequest& request) {
  nlohmann::ordered_json json{{"baseline", request.baseline},
                              {"alpha", request.alpha},
                              {"seed", request.seed},
                              {"exclude_symbols", request.exclude_symbols}};
  if (!request.robot.empty()) json["robot"] = request.robot;
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

using RowName = std::function<std::string(std::size_t row)>;

// What a search begins with. The options are in the bare names of the robot (robot_names.h), the
// baseline is as the record has it.
struct SearchStart {
  std::string robot;  // "": of a cell with one robot
  std::string baseline;
  diagnosis::DiagnoseOptions options;
};

// The formula in a robot's bare names, against its part of the data. The error names channels as
// the data do.
Result<calibration::Candidates> expand_bare(const std::string& formula, const Dataset& dataset,
                                            const formats::RobotNames& names) {
  if (names.robot().empty()) {
    DRIFTWISE_TRY(const auto parsed, formats::Formula::parse(formula));
    return parsed.expand(dataset);
  }
  DRIFTWISE_TRY(const auto parsed, formats::Formula::parse(names.bare(formula)));
  Dataset channels;
  channels.metadata = dataset.metadata;
  for (const auto& column : dataset.columns) channels.columns.push_back({column.channel, {}});
  auto candidates = parsed.expand(names.bare(std::move(channels)));
  if (!candidates) return tl::unexpected(names.with_id(std::move(candidates.error())));
  return candidates;
}

// Checks before the search begins: the robot, the formula against the data, and time.
Result<SearchStart> start_of(const std::shared_ptr<const Dataset>& data,
                             const DiagnosisRequest& request, const RowName& named) {
  const Dataset& dataset = *data;
  DRIFTWISE_TRY(auto robot, formats::robot_asked_for(dataset, request.baseline, request.robot));
  const formats::RobotNames names(dataset, robot);
  DRIFTWISE_TRY(auto candidates, expand_bare(request.baseline, dataset, names));
  for (std::size_t row = 1; row < dataset.time_s.size(); ++row)
    if (dataset.time_s[row] < dataset.time_s[row - 1])
      return fail(ErrorCode::invalid_argument, reasons::kTimeRunsBack,
                  fmt::format("{} is at {:g} s, the row before it at {:g} s: a diagnosis needs the "
                              "rows in time order",
                              named(row), dataset.time_s[row], dataset.time_s[row - 1]));
  diagnosis::DiagnoseOptions options;
  options.baseline = std::move(candidates);
  options.alpha = request.alpha;
  options.seed = static_cast<std::uint64_t>(request.seed);
  for (const auto& symbol : request.exclude_symbols)
    options.exclude_symbols.push_back(names.bare(symbol));
  auto baseline = names.with_id(options.baseline.formula);
  return SearchStart{std::move(robot), std::move(baseline), std::move(options)};
}

}  // namespace

// A baseline that is not given is that of the model it begins from.
Awaitable<Result<void>> DiagnosesService::resolve_baseline(DiagnosisRequest& request) {
  if (request.model || request.baseline.empty()) {
    if (!request.model) request.model = serving_.model();
    if (!request.model)
      co_return fail(ErrorCode::failed_precondition, reasons::kNoModel,
                     description_.has_several_robots()
                         ? "no baseline is given, and a robot of several has no model that serves "
                           "by itself: give its formula (--baseline \"ma.q ~ ...\"), or a model of "
                           "the serving plan (--model N; driftwise plan list)"
                         : "no baseline is given and no model serves: give a formula, or a model");
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
  RunsData loaded;
  if (request.csv.empty() && !request.runs.empty()) {
    DRIFTWISE_CO_TRY(loaded, co_await reader_.call(amended_data, request.runs));
  } else {
    DRIFTWISE_CO_TRY(loaded.data, co_await datasets_.load(request.runs, request.csv));
  }
  const auto shared = std::make_shared<const Dataset>(std::move(loaded.data));
  const RowName named = [origins = std::move(loaded.origins), shared](std::size_t row) {
    return row_name(origins, *shared, row);
  };
  DRIFTWISE_CO_TRY(auto start, co_await run_on(background_, start_of, shared, request, named));
  request.robot = start.robot;
  if (request.csv.empty())
    start.options.levers =
        diagnosis::declared_lever_limits(plans::part_of_robot(description_, start.robot));
  start.options.row_name = named;
  DiagnosisRecord fresh;
  fresh.name = request.name;
  fresh.runs = request.runs;
  fresh.model = request.model;
  fresh.baseline = std::move(start.baseline);
  fresh.request_json = request_json(request);
  auto beginning = desk_.begin(caller, std::move(fresh), shared, std::move(start.options),
                               std::move(start.robot));
  DRIFTWISE_CO_TRY(auto stored, co_await std::move(beginning));
  co_return DiagnosisView{std::move(stored), std::nullopt, std::nullopt, {}};
}

Awaitable<Result<DiagnosisView>> DiagnosesService::get(DiagnosisId id) {
  co_return co_await reader_.call([id](Store& store) -> Result<DiagnosisView> {
    DRIFTWISE_TRY(auto record, store.diagnoses().diagnosis(id));
    DRIFTWISE_TRY(auto view, view_of(store, std::move(record)));
    const auto names_rows = [](const diagnosis::Finding& finding) { return !finding.rows.empty(); };
    if (view.found && !view.record.runs.empty() &&
        std::ranges::any_of(view.found->findings, names_rows)) {
      DRIFTWISE_TRY(auto data, measured_data(store, view.record.runs));
      for (auto& finding : view.found->findings)  // a passage has no row of the plan
        std::erase_if(finding.rows, [&data](std::size_t row) {
          return row < data.data.rows && is_passage(data.data, row);
        });
      view.origins = std::move(data.origins);
    }
    return view;
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
