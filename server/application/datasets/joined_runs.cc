#include "server/application/datasets/joined_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/datasets/extension_preview.h"
#include "server/application/ports/run_plan.h"
#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/correction/described_stage.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/set_names.h"
#include "server/formats/csv/trajectory_csv.h"
#include "server/formats/csv/trajectory_rows.h"
#include "server/formats/join/join_report.h"
#include "server/formats/text/text.h"

namespace driftwise::application {
namespace {

struct NumberedAmendment {
  CorrectionId id;
  correction::DataAmendment amendment;
};

// Of the corrections in force what names runs: the rest is laid over the joined run.
Result<std::vector<NumberedAmendment>> of_single_runs(Store& store) {
  DRIFTWISE_TRY(const auto records, store.extensions().corrections());
  std::vector<NumberedAmendment> found;
  for (const auto& record : records) {
    if (!record.in_force()) continue;
    DRIFTWISE_TRY(auto amendment, amendment_of(store, record));
    std::erase_if(amendment.shifts, [](const auto& shift) { return shift.runs.empty(); });
    std::erase_if(amendment.angles, [](const auto& shift) { return shift.runs.empty(); });
    if (!amendment.empty()) found.push_back({record.id, std::move(amendment)});
  }
  return found;
}

std::string model_text(const RunRecord& run) {
  const Compensation of = compensation_of(run);
  return of.compensated ? compensation_text(of) : std::string();
}

// Mean over the run's datums of each structure temperature.
Result<std::vector<ChannelValue>> datum_temperatures(Store& store, RunId run) {
  DRIFTWISE_TRY(const auto datums, store.points().data(run));
  std::map<std::string, std::pair<double, int>> sums;
  for (const auto& datum : datums)
    for (const auto& value : datum.values)
      if (const auto channel = parse_channel(value.channel);
          channel && is_structure_temperature(*channel) && !is_missing(value.value)) {
        sums[value.channel].first += value.value;
        sums[value.channel].second += 1;
      }
  std::vector<ChannelValue> values;
  for (const auto& [channel, sum] : sums) values.push_back({channel, sum.first / sum.second});
  return values;
}

// The cell file that the run was created under; none: this program cannot read it.
std::optional<CellDescription> cell_of(Store& store, const RunRecord& run,
                                       const CellDescription& present) {
  if (run.config_hash == present.hash) return present;
  const auto text = store.configurations().text(run.config_hash);
  if (!text) return std::nullopt;
  auto cell = formats::parse_cell_file(*text, "cell.toml", present.kinds);
  if (!cell) return std::nullopt;
  return std::move(*cell);
}

void describe(Store& store, const RunRecord& run, const CellDescription& present,
              correction::JoinPart& part) {
  const auto cell = cell_of(store, run, present);
  const std::string robot = correction::measured_robot(part.data);
  if (cell)
    for (const auto& one : cell->robots)
      if (one.id == robot || cell->robots.size() == 1) part.tool = one.tool;
  // A cell file of one set-up has no correction where it lacks the angles: that of the present one.
  if (cell && cell->correction)
    part.stage = correction::stage_from(*cell->correction, robot);
  else if (present.correction)
    part.stage = correction::stage_from(*present.correction, robot);
}

// Of an imported file, one per row; empty: it names none.
std::vector<std::string> set_names_in(const Dataset& data) {
  for (const auto& [key, value] : data.metadata)
    if (key == formats::kSetNamesKey) return formats::unpacked_set_names(value, data.rows);
  return {};
}

void keep_set_names(const std::vector<std::string>& names, const std::vector<std::size_t>& rows,
                    Dataset& data) {
  if (names.empty()) return;
  std::vector<std::string> kept;
  for (const auto row : rows) kept.push_back(names[row]);
  for (auto& [key, value] : data.metadata)
    if (key == formats::kSetNamesKey) value = formats::packed_set_names(kept);
}

Result<correction::JoinPart> part_of(Store& store, RunId id,
                                     const std::vector<NumberedAmendment>& corrections,
                                     const CellDescription& present) {
  DRIFTWISE_TRY(const auto run, store.runs().run(id));
  if (!is_over(run.state))
    return fail(
        ErrorCode::failed_precondition, reasons::kRunUnderWay,
        fmt::format("run {} is {}: join it when it is over", id.value, to_string(run.state)));
  DRIFTWISE_TRY(auto measured, measured_data(store, {&id, 1}));
  correction::JoinPart part;
  part.corrections = corrections_in(run);
  for (const auto& [number, amendment] : corrections) {
    if (!concerns(amendment, run)) continue;
    DRIFTWISE_RETURN_IF_ERROR(
        correction::amend(amendment, measured.origins, measured.time_zero, measured.data));
    part.corrections.push_back(number);
  }
  std::ranges::sort(part.corrections);
  part.name = fmt::format("run {}", id.value);
  part.hash = formats::content_hash(formats::write_dataset_csv(measured.data));
  part.data = std::move(measured.data);
  const auto sets = set_names_in(part.data);
  const auto rows = leave_passages_out(part.data);  // rows are joined by their numbers in the plan
  keep_set_names(sets, rows, part.data);
  part.model = model_text(run);
  if (run.trajectory_text.empty()) {  // imported: its file says what there is to say
    const auto tool =
        std::ranges::find(part.data.metadata, "tool", &std::pair<std::string, std::string>::first);
    if (tool != part.data.metadata.end()) part.tool = tool->second;
    return part;
  }
  for (const auto row : rows) part.row.push_back(measured.origins[row].row);
  DRIFTWISE_TRY(part.trajectory,
                formats::read_trajectory_csv(run.trajectory_text, "trajectory of " + part.name));
  DRIFTWISE_TRY(part.datum, datum_temperatures(store, id));
  describe(store, run, present, part);
  return part;
}

// Of the first part, for the rows that the join has of it. Empty: its sets have no names.
std::vector<std::string> set_names_of(const correction::JoinPart& part,
                                      const std::vector<std::int64_t>& trajectory_rows) {
  const auto names = set_names_in(part.data);
  if (names.empty()) return {};
  std::map<std::int64_t, std::size_t> index_of;
  for (std::size_t i = 0; i < part.data.rows; ++i) index_of[part.row_of(i)] = i;
  std::vector<std::string> out;
  for (const auto row : trajectory_rows) out.push_back(names[index_of.at(row)]);
  return out;
}

}  // namespace

Result<correction::JoinParts> join_parts(Store& store, const std::vector<RunId>& runs,
                                         const CellDescription& present) {
  DRIFTWISE_TRY(const auto corrections, of_single_runs(store));
  correction::JoinParts parts;
  for (const RunId run : runs) {
    DRIFTWISE_TRY(auto part, part_of(store, run, corrections, present));
    parts.push_back(std::move(part));
  }
  return parts;
}

std::vector<CorrectionId> corrections_in(const RunRecord& run) {
  std::vector<CorrectionId> found;
  if (run.reason != "imported") return found;
  const auto rules = nlohmann::json::parse(run.rules_json, nullptr, false);
  const auto parts = nlohmann::json::json_pointer("/joined/parts");
  if (rules.is_discarded() || !rules.contains(parts) || !rules.at(parts).is_array()) return found;
  for (const auto& part : rules.at(parts))
    if (const auto numbers = part.find("corrections"); numbers != part.end())
      for (const auto& number : *numbers)
        if (number.is_number_integer()) found.push_back({number.get<std::int64_t>()});
  std::ranges::sort(found);
  const auto again = std::ranges::unique(found);
  found.erase(again.begin(), again.end());
  return found;
}

Result<JoinedRuns> join_runs(correction::JoinParts parts, const correction::JoinRules& rules,
                             const std::string& cell) {
  DRIFTWISE_TRY(auto joined, correction::join(parts, rules));
  joined.data.metadata = {{std::string(formats::kDatasetVersionKey), "1"}, {"cell", cell}};
  for (auto& line : formats::join_metadata(parts, rules, joined.report))
    joined.data.metadata.push_back(std::move(line));
  if (const auto names = set_names_of(parts.front(), joined.rows); !names.empty())
    joined.data.metadata.emplace_back(formats::kSetNamesKey, formats::packed_set_names(names));
  const auto& first = parts.front();
  DRIFTWISE_TRY(const auto of_file, formats::trajectory_rows(first.data, first.name));
  std::vector<std::int64_t> rows;  // counted from 1
  for (const auto row : joined.rows)
    rows.push_back(first.row.empty() ? of_file[static_cast<std::size_t>(row)] : row + 1);
  formats::set_trajectory_rows(joined.data, rows);
  return JoinedRuns{std::move(joined.data), formats::join_json(parts, rules, joined.report).dump()};
}

}  // namespace driftwise::application
