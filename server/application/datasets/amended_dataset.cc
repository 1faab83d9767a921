#include "server/application/datasets/amended_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "server/application/datasets/extension_preview.h"
#include "server/application/datasets/instruments.h"
#include "server/application/datasets/joined_runs.h"
#include "server/application/ports/run_plan.h"
#include "server/core/data/dataset_parts.h"
#include "server/core/data/measured_by.h"
#include "server/core/data/stated_lines.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/cell_file/sensor_parts.h"
#include "server/formats/cell_file/setup_instruments.h"
#include "server/formats/diagnosis/amendment_json.h"

namespace driftwise::application {
namespace {

// In the order of RunStore::dataset: measured points by their instant, then imported runs as they
// were named, each in the order of its file, which is that of its points.
Result<void> find_origins(Store& store, std::span<const RunId> runs, RunsData& out) {
  std::vector<PointRecord> measured, imported;
  std::set<RunId> of_files;
  for (const RunId run : runs) {
    DRIFTWISE_TRY(const auto record, store.runs().run(run));
    DRIFTWISE_TRY(auto points, points_in_dataset(store, run));
    if (is_of_file(record)) of_files.insert(run);
    auto& to = record.reason == "imported" ? imported : measured;
    std::ranges::move(points, std::back_inserter(to));
  }
  std::ranges::sort(measured, {}, [](const PointRecord& point) {
    return std::tuple(point.measured.utc, point.id.value);
  });
  if (!measured.empty()) out.time_zero = measured.front().measured.utc;
  for (const auto* points : {&measured, &imported})
    for (const auto& point : *points)
      out.origins.push_back({point.run, point.row, of_files.contains(point.run)});
  if (out.origins.size() == out.data.rows) return {};
  return fail(ErrorCode::internal, reasons::kRowsDiffer,
              "the runs have " + std::to_string(out.origins.size()) + " points and their dataset " +
                  std::to_string(out.data.rows) + " rows");
}

// On which part each thermometer is, by the cell files that the runs were measured under.
void add_parts(Store& store, std::span<const RunId> runs, Dataset& dataset) {
  std::set<std::string> looked_at;
  std::map<std::string, std::string> parts;
  for (const RunId run : runs) {
    const auto used = store.configurations().of_run(run);
    if (!used || used->empty() || !looked_at.insert(used->back().hash).second) continue;
    const auto text = store.configurations().text(used->back().hash);
    if (!text) continue;
    for (const auto& [symbol, part] : formats::sensor_parts(*text))
      if (dataset.find(symbol)) parts[symbol] = part;
  }
  if (!parts.empty())
    dataset.metadata.emplace_back(kPartsKey, parts_text({parts.begin(), parts.end()}));
}

// Which instruments gave the coordinates, by the set-ups that the runs state. A coordinate that one
// of them does not state is left out.
void add_instruments(Store& store, std::span<const RunId> runs, Dataset& dataset) {
  std::map<std::string, MeasuredBy> stated;
  for (const RunId id : runs) {
    const auto run = store.runs().run(id);
    const std::string setup = run ? setup_of(*run) : std::string();
    if (setup.empty()) return;
    const auto used = store.configurations().of_run(id);
    if (!used || used->empty()) return;
    const auto text = store.configurations().text(used->back().hash);
    if (!text) return;
    const double rows = dataset.run.empty()
                            ? static_cast<double>(dataset.rows)
                            : static_cast<double>(std::ranges::count(dataset.run, id.value));
    if (rows == 0) continue;
    const auto devices = formats::setup_instruments(*text, setup);
    if (stated.empty() && id == runs.front())
      for (const auto& [symbol, device] : devices)
        if (dataset.find(symbol)) stated[symbol].symbol = symbol;
    std::erase_if(stated, [&](const auto& one) { return !devices.contains(one.first); });
    for (auto& [symbol, coordinate] : stated) {
      auto& parts = coordinate.parts;
      const std::vector<std::string> by = {devices.at(symbol)};
      const auto same = std::ranges::find(parts, by, &MeasuredRows::devices);
      if (same == parts.end())
        parts.push_back({by, rows});
      else
        same->rows += rows;
    }
  }
  std::vector<MeasuredBy> coordinates;
  for (auto& [symbol, coordinate] : stated)
    if (!coordinate.parts.empty()) coordinates.push_back(std::move(coordinate));
  if (!coordinates.empty())
    dataset.metadata.emplace_back(kMeasuredByKey, measured_by_text(coordinates));
}

// Files state what they state, alone and together (RunStore::dataset); measured runs, what their
// cell files say. Beside files these state it together, as one more file.
Result<void> add_metadata(Store& store, std::span<const RunId> runs, Dataset& dataset) {
  StatedLines measured;
  std::vector<StatedLines> of_files;
  for (const RunId id : runs) {
    DRIFTWISE_TRY(const auto run, store.runs().run(id));
    if (run.reason != "imported") {
      measured.runs.push_back(id);
      continue;
    }
    of_files.push_back({{id}, {}});
  }
  if (measured.runs.empty()) return {};
  dataset.metadata.clear();
  add_parts(store, measured.runs, dataset);
  add_instruments(store, measured.runs, dataset);
  if (of_files.empty()) return {};
  measured.lines = std::move(dataset.metadata);
  std::vector<StatedLines> sources = {std::move(measured)};
  for (auto& file : of_files) {
    DRIFTWISE_TRY(auto alone, store.runs().dataset(file.runs));
    file.lines = std::move(alone.metadata);
    sources.push_back(std::move(file));
  }
  DRIFTWISE_TRY(dataset.metadata, stated_together(dataset, sources));
  return {};
}

Result<bool> any_of_file(Store& store, std::span<const RunId> runs) {
  for (const RunId id : runs) {
    DRIFTWISE_TRY(const auto run, store.runs().run(id));
    if (is_of_file(run)) return true;
  }
  return false;
}

}  // namespace

Result<std::vector<PointRecord>> points_in_dataset(Store& store, RunId run, std::size_t limit) {
  const int page_size = limit == 0 ? 5000 : 100;
  DRIFTWISE_TRY(const auto repeated, store.closures().repeated_points(run));
  std::vector<PointRecord> points;
  for (std::int64_t after = 0;;) {
    DRIFTWISE_TRY(auto page, store.points().points(run, after, page_size));
    if (page.empty()) return points;
    after = page.back().id.value;
    for (auto& point : page) {
      if (std::ranges::binary_search(repeated, point.id)) continue;
      points.push_back(std::move(point));
      if (points.size() == limit) return points;
    }
  }
}

Result<RunsData> measured_data(Store& store, std::span<const RunId> runs) {
  // Rows and points are two reads: a run under way can store a point in between.
  constexpr int kMostReads = 3;
  for (int read = 1;; ++read) {
    RunsData out;
    DRIFTWISE_TRY(out.data, store.runs().dataset(runs));
    DRIFTWISE_RETURN_IF_ERROR(add_metadata(store, runs, out.data));
    const auto found = find_origins(store, runs, out);
    if (found) return out;
    if (found.error().reason != reasons::kRowsDiffer || read == kMostReads)
      return tl::unexpected(found.error());
  }
}

void confine(correction::DataAmendment& amendment, const std::vector<RunId>& runs) {
  for (auto& shift : amendment.shifts)
    if (shift.runs.empty()) shift.runs = runs;
}

// Earlier versions accepted a finding about an instrument of a file, or of one set-up, for every
// run.
Result<correction::DataAmendment> amendment_of(Store& store, const CorrectionRecord& record) {
  auto amendment = formats::read_amendment_json(record.json);
  if (!amendment)
    return fail(ErrorCode::data_loss, reasons::kBadCorrection,
                "correction " + std::to_string(record.id.value) + ": " + amendment.error().message);
  if (!record.diagnosis || !concerns_every_run(*amendment)) return amendment;
  DRIFTWISE_TRY(const auto diagnosis, store.diagnoses().diagnosis(*record.diagnosis));
  DRIFTWISE_TRY(const bool of_file, any_of_file(store, diagnosis.runs));
  if (of_file) {
    confine(*amendment, diagnosis.runs);
    return amendment;
  }
  const auto is_open = [](const auto& shift) { return shift.runs.empty() && shift.device.empty(); };
  if (std::ranges::none_of(amendment->shifts, is_open)) return amendment;
  DRIFTWISE_TRY(const auto instruments, instruments_of(store, diagnosis.runs));
  for (auto& shift : amendment->shifts) {
    const auto by = instruments.find(shift.axis);
    if (!is_open(shift) || by == instruments.end()) continue;
    if (by->second.size() == 1)
      shift.device = by->second.front();
    else
      shift.runs = diagnosis.runs;
  }
  return amendment;
}

namespace {

// In force but for this one, oldest first.
Result<std::vector<correction::DataAmendment>> amendments_without(
    Store& store, std::optional<CorrectionId> correction) {
  DRIFTWISE_TRY(const auto records, store.extensions().corrections());
  std::vector<correction::DataAmendment> amendments;
  for (const auto& record : records) {
    if (!record.in_force() || record.id == correction) continue;
    DRIFTWISE_TRY(auto amendment, amendment_of(store, record));
    amendments.push_back(std::move(amendment));
  }
  return amendments;
}

Result<RunsData> data_without(Store& store, std::span<const RunId> runs,
                              std::optional<CorrectionId> correction) {
  auto out = measured_data(store, runs);
  if (!out) return out;
  DRIFTWISE_TRY(auto amendments, amendments_without(store, correction));
  for (auto& whole : amendments) {
    DRIFTWISE_TRY(const auto amendment, held_for(store, std::move(whole), runs));
    DRIFTWISE_RETURN_IF_ERROR(
        correction::amend(amendment, out->origins, out->time_zero, out->data));
  }
  return out;
}

// The corrections, ended ones too, that can change the data of one of these runs.
Result<std::vector<CorrectionRecord>> corrections_of(Store& store, std::span<const RunId> runs) {
  DRIFTWISE_TRY(auto records, store.extensions().corrections());
  std::vector<RunRecord> asked;
  for (const RunId id : runs) {
    DRIFTWISE_TRY(auto run, store.runs().run(id));
    asked.push_back(std::move(run));
  }
  std::vector<CorrectionRecord> over;
  for (auto& record : records) {
    DRIFTWISE_TRY(auto whole, amendment_of(store, record));
    DRIFTWISE_TRY(const auto amendment, held_for(store, std::move(whole), runs));
    if (std::ranges::any_of(asked, [&](const auto& run) { return concerns(amendment, run); }))
      over.push_back(std::move(record));
  }
  return over;
}

}  // namespace

Result<std::vector<CorrectionId>> corrections_over(Store& store, std::span<const RunId> runs) {
  DRIFTWISE_TRY(const auto records, corrections_of(store, runs));
  std::vector<CorrectionId> over;
  for (const auto& record : records)
    if (record.in_force()) over.push_back(record.id);
  for (const RunId id : runs) {
    DRIFTWISE_TRY(const auto run, store.runs().run(id));
    for (const CorrectionId inside : corrections_in(run)) over.push_back(inside);
  }
  std::ranges::sort(over);
  const auto again = std::ranges::unique(over);
  over.erase(again.begin(), again.end());
  return over;
}

Result<std::vector<std::string>> corrections_since(Store& store, std::span<const RunId> runs,
                                                   CellTime since) {
  DRIFTWISE_TRY(const auto records, corrections_of(store, runs));
  std::vector<std::string> changes;
  for (const auto& record : records) {
    if (record.in_force() && record.created > since)
      changes.push_back(fmt::format("correction {} came into force", record.id.value));
    if (!record.in_force() && record.created <= since && record.ended > since)
      changes.push_back(fmt::format("correction {} was taken back", record.id.value));
  }
  return changes;
}

Result<RunsData> amended_data(Store& store, std::span<const RunId> runs) {
  return data_without(store, runs, std::nullopt);
}

Result<Dataset> amended_dataset(Store& store, std::span<const RunId> runs) {
  return dataset_without(store, runs, std::nullopt);
}

Result<Dataset> dataset_without(Store& store, std::span<const RunId> runs,
                                std::optional<CorrectionId> correction) {
  DRIFTWISE_TRY(const auto records, store.extensions().corrections());
  if (std::ranges::none_of(records, &CorrectionRecord::in_force)) {
    auto dataset = store.runs().dataset(runs);  // nothing to lay over: as ever
    if (!dataset) return dataset;
    DRIFTWISE_RETURN_IF_ERROR(add_metadata(store, runs, *dataset));
    return dataset;
  }
  DRIFTWISE_TRY(auto amended, data_without(store, runs, correction));
  return std::move(amended.data);
}

}  // namespace driftwise::application
