#include "server/application/datasets/datasets_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/datasets/joined_runs.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/ports/run_plan.h"
#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/set_names.h"
#include "server/formats/csv/trajectory_rows.h"
#include "server/formats/text/text.h"

namespace driftwise::application {
namespace {

// "run 4 with model 3, run 5 none, run 6 imported": a compensated run is told from an uncompensated
// one, and from rows of which this cell knows neither.
std::string compensations(Store& store, const std::vector<RunId>& runs) {
  std::string text;
  for (const auto& run : runs) {
    const auto record = store.runs().run(run);
    if (!record) continue;
    const Compensation of = compensation_of(*record);
    text += fmt::format("{}run {} {}", text.empty() ? "" : ", ", run.value,
                        is_of_file(*record) ? "imported"
                        : of.compensated    ? "with " + compensation_text(of)
                                            : "none");
  }
  return text;
}

// The instant of the runs' first row; nothing when none was measured.
std::optional<CellTime> time_zero(Store& store, const std::vector<RunId>& runs) {
  std::optional<CellTime> first;
  for (const RunId id : runs) {
    const auto run = store.runs().run(id);
    if (!run || run->reason == "imported") continue;
    if (const auto points = points_in_dataset(store, id, 1); points && !points->empty())
      first = std::min(first.value_or(points->front().measured.utc), points->front().measured.utc);
  }
  return first;
}

// Names of the sets of every row, where a trajectory or an imported file gave them (set_names.h).
// Empty: none did, or they cannot be told.
std::vector<std::string> set_names_of(Store& store, const std::vector<RunId>& runs,
                                      const Dataset& dataset) {
  const auto kept = std::ranges::find(dataset.metadata, std::string(formats::kSetNamesKey),
                                      &std::pair<std::string, std::string>::first);
  if (kept != dataset.metadata.end())
    return formats::unpacked_set_names(kept->second, dataset.rows);
  std::map<std::int64_t, std::vector<std::string>> by_run;  // in the order of its points
  bool any = false;
  bool with_passages = false;  // a part of a join has none
  for (std::size_t row = 0; row < dataset.rows; ++row)
    with_passages = with_passages || is_passage(dataset, row);
  for (const RunId id : runs) {
    const auto run = store.runs().run(id);
    if (!run) return {};
    const auto of_rows = formats::read_set_names(run->trajectory_text, "trajectory");
    const auto points = points_in_dataset(store, id);
    if (!points) return {};
    auto& names = by_run[id.value];
    for (const auto& point : *points) {
      if (point.passage && !with_passages) continue;
      const auto row = static_cast<std::size_t>(point.row);
      const bool has = of_rows && row < of_rows->size();
      names.push_back(has                                 ? (*of_rows)[row]
                      : point.set == PointSet::validation ? "validation"
                                                          : "calibration");
      any = any || (has && names.back() != "calibration" && names.back() != "validation");
    }
  }
  if (!any || (runs.size() > 1 && dataset.run.empty())) return {};
  std::map<std::int64_t, std::size_t> next;
  std::vector<std::string> names;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    const std::int64_t run = runs.size() > 1 ? dataset.run[row] : runs.front().value;
    const auto& of_run = by_run[run];
    const std::size_t at = next[run]++;
    if (at >= of_run.size()) return {};
    names.push_back(of_run[at]);
  }
  return names;
}

using Names = Result<std::vector<std::string>>;

Names named_or_none(std::vector<std::string> names) {
  if (formats::named_sets(names).empty()) names.clear();
  return names;
}
Names named_sets_of(Store& store, const std::vector<RunId>& runs) {
  DRIFTWISE_TRY(const auto dataset, amended_dataset(store, runs));
  return named_or_none(set_names_of(store, runs, dataset));
}
Names named_sets_in(const std::string& csv) {
  DRIFTWISE_TRY(auto names, formats::read_set_names(csv, "dataset"));
  return named_or_none(std::move(names));
}

void drop_set_names(Dataset& dataset) {
  std::erase_if(dataset.metadata,
                [](const auto& line) { return line.first == formats::kSetNamesKey; });
}

struct ParsedFile {
  Dataset dataset;
  std::string hash;  // of the text
};

Result<ParsedFile> parsed(const std::string& csv, const std::string& name) {
  DRIFTWISE_TRY(auto dataset, formats::read_dataset_csv(csv, name.empty() ? "dataset" : name, {},
                                                        formats::kRequestLimits));
  // The store keeps which rows validate; names of sets are kept as a line of metadata. A file that
  // has such a line of its own names its sets in the column all the same.
  drop_set_names(dataset);
  DRIFTWISE_TRY(const auto names, formats::read_set_names(csv, "dataset"));
  if (!formats::named_sets(names).empty())
    dataset.metadata.emplace_back(formats::kSetNamesKey, formats::packed_set_names(names));
  return ParsedFile{std::move(dataset), formats::content_hash(csv)};
}

// Row of the trajectory, from 1, of each row of the dataset; 0: a passage. Empty: it is of several
// runs, or they cannot be told.
std::vector<std::int64_t> trajectory_rows_of(Store& store, const std::vector<RunId>& runs,
                                             const Dataset& dataset) {
  if (runs.size() != 1) return {};
  const auto run = store.runs().run(runs.front());
  if (!run) return {};
  std::vector<std::int64_t> rows;
  if (run->reason == "imported") {
    const auto of_file = formats::trajectory_rows(dataset, "dataset");
    if (!of_file) return {};
    for (std::size_t row = 0, next = 0; row < dataset.rows; ++row)
      rows.push_back(is_passage(dataset, row) ? 0 : (*of_file)[next++]);
    return rows;
  }
  auto points = points_in_dataset(store, runs.front());
  if (!points || points->size() != dataset.rows) return {};
  std::ranges::sort(*points, {}, [](const PointRecord& point) {
    return std::tuple(point.measured.utc, point.id.value);
  });
  for (const auto& point : *points) rows.push_back(point.passage ? 0 : point.row + 1);
  return rows;
}

// Those whose rows are a file's.
Result<std::vector<std::int64_t>> runs_of_files(Store& store, const std::vector<RunId>& runs) {
  std::vector<std::int64_t> of_files;
  for (const RunId id : runs) {
    DRIFTWISE_TRY(const auto run, store.runs().run(id));
    if (is_of_file(run)) of_files.push_back(id.value);
  }
  return of_files;
}

// The runs' rows as a dataset file, with the cell, the runs and the corrections in its metadata.
Result<std::string> exported(Store& store, const std::vector<RunId>& runs, bool without_excluded,
                             const std::string& cell, Clock* clock) {
  DRIFTWISE_TRY(auto dataset, amended_dataset(store, runs));
  auto set_names = set_names_of(store, runs, dataset);
  drop_set_names(dataset);
  auto rows = trajectory_rows_of(store, runs, dataset);
  if (without_excluded) {
    for (std::size_t row = 0; row < rows.size(); ++row)
      if (dataset.is_excluded(row)) rows[row] = 0;
    std::vector<std::string> kept;
    for (std::size_t row = 0; row < set_names.size(); ++row)
      if (!dataset.is_excluded(row)) kept.push_back(std::move(set_names[row]));
    set_names = std::move(kept);
    leave_excluded_out(dataset);
  }
  DRIFTWISE_TRY(const auto of_files, runs_of_files(store, runs));
  DRIFTWISE_TRY(const auto first, store.runs().run(runs.front()));
  // One imported run keeps what its file says, or does not say.
  if (runs.size() > 1 || first.reason != "imported") {
    const auto stated = std::move(dataset.metadata);  // parts, instruments, ...
    dataset.metadata = {{std::string(formats::kDatasetVersionKey), "1"}};
    const bool all_of_files = of_files.size() == runs.size();
    if (!all_of_files) dataset.metadata.emplace_back("cell", cell);
    std::string numbers;
    for (const auto& run : runs)
      numbers += (numbers.empty() ? "" : ", ") + std::to_string(run.value);
    dataset.metadata.emplace_back("runs", numbers);
    if (!all_of_files) dataset.metadata.emplace_back("compensation", compensations(store, runs));
    if (const auto zero = time_zero(store, runs))  // what time_s counts from
      dataset.metadata.emplace_back("time_zero", to_iso8601(clock->utc(*zero)));
    dataset.metadata.insert(dataset.metadata.end(), stated.begin(), stated.end());
  }
  // "1, 3": a reader elsewhere learns that the lengths are not as they were read.
  DRIFTWISE_TRY(const auto corrections, corrections_over(store, runs));
  std::string corrected;
  for (const CorrectionId id : corrections)
    corrected += (corrected.empty() ? "" : ", ") + std::to_string(id.value);
  if (!corrected.empty()) dataset.metadata.emplace_back("corrections", corrected);
  std::erase(rows, 0);
  if (runs.size() == 1) formats::set_trajectory_rows(dataset, rows);
  auto csv = formats::write_dataset_csv(dataset);
  return set_names.empty() ? csv : formats::with_set_names(csv, set_names);
}

// With what a join has of its first part: the instant of its first row, the names of its sets.
Result<correction::JoinParts> parts_of_join(Store& store, const std::vector<RunId>& runs,
                                            const CellDescription* present, Clock* clock) {
  DRIFTWISE_TRY(auto parts, join_parts(store, runs, *present));
  if (parts.empty()) return parts;
  Dataset& first = parts.front().data;
  const auto names = set_names_of(store, {runs.front()}, first);
  drop_set_names(first);
  if (!formats::named_sets(names).empty())
    first.metadata.emplace_back(formats::kSetNamesKey, formats::packed_set_names(names));
  if (const auto zero = time_zero(store, {runs.front()}))
    first.metadata.emplace_back("time_zero", to_iso8601(clock->utc(*zero)));
  return parts;
}

}  // namespace

Awaitable<Result<Dataset>> DatasetsService::load(std::vector<RunId> runs, std::string csv) {
  if (runs.empty() == csv.empty())
    co_return fail(ErrorCode::invalid_argument, reasons::kNoData,
                   "a fit needs runs or a dataset, one of the two");
  if (csv.empty()) co_return co_await reader_.call(amended_dataset, runs);
  co_return co_await run_on(
      background_,
      [](const std::string& text) {
        return formats::read_dataset_csv(text, "dataset", {}, formats::kRequestLimits);
      },
      csv);
}

Awaitable<Result<std::vector<std::string>>> DatasetsService::set_names(std::vector<RunId> runs,
                                                                       std::string csv) {
  if (csv.empty()) co_return co_await reader_.call(named_sets_of, runs);
  co_return co_await run_on(background_, named_sets_in, csv);
}

Awaitable<Result<std::string>> DatasetsService::export_csv(std::vector<RunId> runs,
                                                           bool without_excluded) {
  co_return co_await reader_.call(exported, std::move(runs), without_excluded, description_.name,
                                  &clock_);
}

Awaitable<Result<RunRecord>> DatasetsService::import_csv(Caller caller, std::string name,
                                                         std::string csv, std::string request_id) {
  DRIFTWISE_CO_TRY(auto file, co_await run_on(background_, parsed, std::move(csv), name));
  Dataset* const dataset = &file.dataset;
  NewRun fresh;
  fresh.name = name;
  fresh.rows = static_cast<std::int64_t>(dataset->rows);
  // An import follows no rules; what it was made of tells a repeat from another import.
  fresh.rules_json = nlohmann::json{{"imported_hash", file.hash}}.dump();
  fresh.request_id = std::move(request_id);
  fresh.config_hash = description_.hash;
  fresh.config_text = description_.text;
  fresh.operator_name = caller.name;
  fresh.created = clock_.now();
  auto stored = co_await writer_.runs().import_dataset(fresh, std::move(*dataset));
  const bool is_repeat = stored && stored->created != fresh.created.utc;
  if (stored && !is_repeat)
    events_.record(caller, "data.imported",
                   fmt::format("{} imported '{}': {} rows", caller.name, name, stored->rows),
                   stored->id);
  co_return stored;
}

Awaitable<Result<JoinAnswer>> DatasetsService::join(Caller caller, JoinRequest request) {
  DRIFTWISE_CO_TRY(auto parts,
                   co_await reader_.call(parts_of_join, request.runs, &description_, &clock_));
  DRIFTWISE_CO_TRY(const auto of_files, co_await reader_.call(runs_of_files, request.runs));
  DRIFTWISE_CO_TRY(auto joined, co_await run_on(background_, join_runs, std::move(parts),
                                                request.rules, description_.name));
  if (request.dry_run) co_return JoinAnswer{std::nullopt, std::move(joined.report_json)};
  std::string numbers;
  for (const RunId run : request.runs)
    numbers += (numbers.empty() ? "" : ", ") + std::to_string(run.value);
  NewRun fresh;
  fresh.name = request.name.empty() ? "join of runs " + numbers : request.name;
  fresh.rows = static_cast<std::int64_t>(joined.data.rows);
  nlohmann::ordered_json rules;
  if (!of_files.empty()) rules["runs_of_files"] = of_files;  // before "joined": a file's rows, too
  rules["joined"] = nlohmann::ordered_json::parse(joined.report_json);
  fresh.rules_json = rules.dump();
  fresh.request_id = std::move(request.request_id);
  fresh.config_hash = description_.hash;
  fresh.config_text = description_.text;
  fresh.operator_name = caller.name;
  fresh.created = clock_.now();
  fresh.metadata = {{"joined", numbers.substr(0, 256)}};
  auto stored = co_await writer_.runs().import_dataset(fresh, std::move(joined.data));
  DRIFTWISE_CO_TRY(auto run, std::move(stored));
  if (run.created == fresh.created.utc)
    events_.record(
        caller, "data.joined",
        fmt::format("{} joined runs {} as '{}': {} rows", caller.name, numbers, run.name, run.rows),
        run.id);
  co_return JoinAnswer{std::move(run), std::move(joined.report_json)};
}

}  // namespace driftwise::application
