#include "server/application/datasets/joined_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/ports/run_plan.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/correction/described_stage.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/trajectory_csv.h"
#include "server/formats/join/join_report.h"
#include "server/formats/text/text.h"

namespace driftwise::application {
namespace {

// Of the amendments in force what names runs: the rest is laid over the joined run.
std::vector<correction::DataAmendment> of_single_runs(
    std::vector<correction::DataAmendment> amendments) {
  for (auto& amendment : amendments) {
    std::erase_if(amendment.shifts, [](const auto& shift) { return shift.runs.empty(); });
    std::erase_if(amendment.angles, [](const auto& shift) { return shift.runs.empty(); });
  }
  std::erase_if(amendments, [](const auto& amendment) { return amendment.empty(); });
  return amendments;
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

Result<correction::JoinPart> part_of(Store& store, RunId id,
                                     const std::vector<correction::DataAmendment>& amendments,
                                     const CellDescription& present) {
  DRIFTWISE_TRY(const auto run, store.runs().run(id));
  if (!is_over(run.state))
    return fail(
        ErrorCode::failed_precondition, reasons::kRunUnderWay,
        fmt::format("run {} is {}: join it when it is over", id.value, to_string(run.state)));
  DRIFTWISE_TRY(auto measured, measured_data(store, {&id, 1}));
  for (const auto& amendment : amendments)
    DRIFTWISE_RETURN_IF_ERROR(
        correction::amend(amendment, measured.origins, measured.time_zero, measured.data));
  correction::JoinPart part;
  part.name = fmt::format("run {}", id.value);
  part.hash = formats::content_hash(formats::write_dataset_csv(measured.data));
  part.data = std::move(measured.data);
  part.model = model_text(run);
  if (run.trajectory_text.empty()) {  // imported: its file says what there is to say
    const auto tool =
        std::ranges::find(part.data.metadata, "tool", &std::pair<std::string, std::string>::first);
    if (tool != part.data.metadata.end()) part.tool = tool->second;
    return part;
  }
  for (const auto& origin : measured.origins) part.row.push_back(origin.row);
  DRIFTWISE_TRY(part.trajectory,
                formats::read_trajectory_csv(run.trajectory_text, "trajectory of " + part.name));
  DRIFTWISE_TRY(part.datum, datum_temperatures(store, id));
  describe(store, run, present, part);
  return part;
}

}  // namespace

Result<correction::JoinParts> join_parts(Store& store, const std::vector<RunId>& runs,
                                         const CellDescription& present) {
  DRIFTWISE_TRY(auto amendments, amendments_in_force(store));
  amendments = of_single_runs(std::move(amendments));
  correction::JoinParts parts;
  for (const RunId run : runs) {
    DRIFTWISE_TRY(auto part, part_of(store, run, amendments, present));
    parts.push_back(std::move(part));
  }
  return parts;
}

Result<JoinedRuns> join_runs(correction::JoinParts parts, const correction::JoinRules& rules,
                             const std::string& cell) {
  DRIFTWISE_TRY(auto joined, correction::join(parts, rules));
  joined.data.metadata = {{std::string(formats::kDatasetVersionKey), "1"}, {"cell", cell}};
  for (auto& line : formats::join_metadata(parts, rules, joined.report))
    joined.data.metadata.push_back(std::move(line));
  return JoinedRuns{std::move(joined.data), formats::join_json(parts, rules, joined.report).dump()};
}

}  // namespace driftwise::application
