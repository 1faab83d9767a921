#include <algorithm>

#include "server/application/datasets/datasets.h"
#include "server/application/ports/host.h"
#include "server/rpc/shared/source_task.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using application::Datasets;
using application::Host;
constexpr std::size_t kChunkBytes = 64 * 1024;

struct ExportState {  // shared with the query, which may end after the client has gone
  std::string csv;
  std::size_t sent = 0;
  std::optional<Result<void>> end;
  std::function<void()> wake;
};

Awaitable<void> query(Datasets& datasets, std::vector<RunId> runs, bool without_excluded,
                      std::shared_ptr<ExportState> state) {
  auto csv = co_await datasets.export_csv(std::move(runs), without_excluded);
  if (csv) {
    state->csv = std::move(*csv);
    state->end = Result<void>{};
  } else {
    state->end = tl::unexpected(csv.error());
  }
  state->wake();
}

class ExportSource final : public StreamSource<v1::ExportDatasetResponse> {
 public:
  ExportSource(const Host& host, Datasets& datasets, std::vector<RunId> runs, bool without_excluded)
      : host_(host),
        datasets_(datasets),
        runs_(std::move(runs)),
        without_excluded_(without_excluded) {}
  ~ExportSource() override {
    state_->wake = [] {};
  }

  void start(std::function<void()> wake) override {
    state_->wake = std::move(wake);
    spawn_for_source(host_.executor(), query(datasets_, runs_, without_excluded_, state_), state_);
  }

  std::optional<v1::ExportDatasetResponse> next() override {
    const std::size_t size = std::min(kChunkBytes, state_->csv.size() - state_->sent);
    if (size == 0) return std::nullopt;
    v1::ExportDatasetResponse response;
    response.set_chunk(state_->csv.substr(state_->sent, size));
    response.set_total_bytes(static_cast<std::int64_t>(state_->csv.size()));
    state_->sent += size;
    return response;
  }
  std::optional<Result<void>> ended() override { return state_->end; }

 private:
  const Host& host_;
  Datasets& datasets_;
  std::vector<RunId> runs_;
  bool without_excluded_;
  std::shared_ptr<ExportState> state_ = std::make_shared<ExportState>();
};

}  // namespace

std::unique_ptr<StreamSource<v1::ExportDatasetResponse>> export_dataset(const Host& host,
                                                                        Datasets& datasets,
                                                                        std::vector<RunId> runs,
                                                                        bool without_excluded) {
  return std::make_unique<ExportSource>(host, datasets, std::move(runs), without_excluded);
}

}  // namespace driftwise::rpc
