// Datasets in and out.

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "server/application/cell_application.h"
#include "server/formats/dataset_csv.h"

namespace driftwise::application {
namespace {

// The instant of the runs' first point; nothing when none was accepted.
std::optional<CellTime> time_zero(Store& store, const std::vector<RunId>& runs) {
  std::optional<CellTime> first;
  for (const RunId run : runs)
    if (const auto points = store.runs().points(run, 0, 1); points && !points->empty())
      first = std::min(first.value_or(points->front().measured.utc), points->front().measured.utc);
  return first;
}

}  // namespace

Awaitable<Result<std::string>> CellApplication::export_dataset(std::vector<RunId> runs) {
  auto exporting =
      reader_.call([runs, cell = description_.name](Store& store) -> Result<std::string> {
        auto dataset = store.runs().dataset(runs);
        if (!dataset) return tl::unexpected(dataset.error());
        if (dataset->metadata.empty()) {  // an imported file keeps its own
          dataset->metadata = {{"driftwise-dataset", "1"}, {"cell", cell}};
          std::string numbers;
          for (const auto& run : runs)
            numbers += (numbers.empty() ? "" : ", ") + std::to_string(run.value);
          dataset->metadata.emplace_back("runs", numbers);
          if (const auto zero = time_zero(store, runs))  // what time_s counts from
            dataset->metadata.emplace_back("time_zero", to_iso8601(*zero));
        }
        return formats::write_dataset_csv(*dataset);
      });
  co_return co_await std::move(exporting);
}

Awaitable<Result<RunRecord>> CellApplication::import_dataset(Caller caller, std::string name,
                                                             std::string csv) {
  auto dataset = formats::read_dataset_csv(csv, name.empty() ? "dataset" : name);
  if (!dataset) co_return tl::unexpected(dataset.error());
  NewRun fresh;
  fresh.name = name;
  fresh.rows = static_cast<std::int64_t>(dataset->rows);
  fresh.rules_json = "{}";
  fresh.config_hash = description_.hash;
  fresh.config_text = description_.text;
  fresh.operator_name = caller.name;
  fresh.created = clock_->now();
  auto storing = writer_.call([fresh, data = std::move(*dataset)](Store& store) {
    return store.runs().import_dataset(fresh, data);
  });
  auto stored = co_await std::move(storing);
  if (stored)
    events_.record(caller, "data.imported",
                   fmt::format("{} imported '{}': {} rows", caller.name, name, stored->rows),
                   stored->id);
  co_return stored;
}

}  // namespace driftwise::application
