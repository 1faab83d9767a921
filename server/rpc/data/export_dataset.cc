#include "server/application/datasets/datasets.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {

std::unique_ptr<StreamSource<v1::ExportDatasetResponse>> export_dataset(
    std::shared_ptr<WholeTexts> texts, application::Datasets& datasets, std::vector<RunId> runs,
    bool without_excluded) {
  return std::make_unique<WholeTextSource<v1::ExportDatasetResponse>>(
      std::move(texts),
      [&datasets, runs = std::move(runs), without_excluded] {
        return datasets.export_csv(runs, without_excluded);
      },
      [](v1::ExportDatasetResponse& response, std::string piece, std::size_t whole_bytes) {
        response.set_chunk(std::move(piece));
        response.set_total_bytes(static_cast<std::int64_t>(whole_bytes));
      });
}

}  // namespace driftwise::rpc
