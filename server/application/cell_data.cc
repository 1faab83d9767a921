// Datasets in and out.

#include <fmt/format.h>

#include "server/application/cell_application.h"
#include "server/formats/dataset_csv.h"

namespace driftwise::application {

Awaitable<Result<std::string>> CellApplication::export_dataset(std::vector<RunId> runs) {
  co_return co_await reader_.call(
      [runs, cell = description_.name](Store& store) -> Result<std::string> {
        auto dataset = store.runs().dataset(runs);
        if (!dataset) return tl::unexpected(dataset.error());
        if (dataset->metadata.empty()) {  // an imported file keeps its own
          dataset->metadata = {{"driftwise-dataset", "1"}, {"cell", cell}};
          std::string numbers;
          for (const auto& run : runs)
            numbers += (numbers.empty() ? "" : ", ") + std::to_string(run.value);
          dataset->metadata.emplace_back("runs", numbers);
        }
        return formats::write_dataset_csv(*dataset);
      });
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
  auto stored = co_await writer_.call([fresh, data = std::move(*dataset)](Store& store) {
    return store.runs().import_dataset(fresh, data);
  });
  if (stored)
    events_.record(caller, "data.imported",
                   fmt::format("{} imported '{}': {} rows", caller.name, name, stored->rows),
                   stored->id);
  co_return stored;
}

}  // namespace driftwise::application
