#include "driftwise/v1/data_service.grpc.pb.h"
#include "server/rpc/caller.h"
#include "server/rpc/convert_run.h"
#include "server/rpc/request_checks.h"
#include "server/rpc/services.h"
#include "server/rpc/unary.h"
#include "server/rpc/watch_sources.h"

namespace driftwise::rpc {
namespace {

class DataService final : public v1::DataService::CallbackService {
 public:
  explicit DataService(application::Cell& cell) : cell_(cell) {}

  grpc::ServerWriteReactor<v1::ExportDatasetResponse>* ExportDataset(
      grpc::CallbackServerContext*, const v1::ExportDatasetRequest* request) override {
    auto runs = run_ids_from(request->run_ids());
    if (!runs) return refuse_stream<v1::ExportDatasetResponse>(runs.error());
    if (runs->empty())
      return refuse_stream<v1::ExportDatasetResponse>(
          {ErrorCode::invalid_argument, "NO_RUNS", "run_ids: found none, expected at least one"});
    return Stream<v1::ExportDatasetResponse>::open(cell_.executor(),
                                                   export_dataset(cell_, std::move(*runs)));
  }

  grpc::ServerUnaryReactor* ImportDataset(grpc::CallbackServerContext* context,
                                          const v1::ImportDatasetRequest* request,
                                          v1::ImportDatasetResponse* response) override {
    return answer(cell_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_size(request->name(), kMostNameBytes, "name"); !good) co_return good;
      if (auto good = check_size(request->csv(), kMostDatasetBytes, "csv"); !good) co_return good;
      const auto run =
          co_await cell_.import_dataset(caller_of(*context), request->name(), request->csv());
      if (!run) co_return tl::unexpected(run.error());
      *response->mutable_run() = run_from(*run);
      co_return Result<void>{};
    });
  }

 private:
  application::Cell& cell_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_data_service(application::Cell& cell) {
  return std::make_unique<DataService>(cell);
}

}  // namespace driftwise::rpc
