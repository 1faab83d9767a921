#include "driftwise/v1/standards_service.grpc.pb.h"
#include "server/application/datasets/datasets.h"
#include "server/application/plumbing/run_on.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"
#include "server/rpc/standards/convert_standards.h"

namespace driftwise::rpc {
namespace {

class StandardsService final : public v1::StandardsService::CallbackService {
 public:
  explicit StandardsService(const application::Services& cell)
      : host_(cell.host), datasets_(cell.datasets) {}

  grpc::ServerUnaryReactor* EvaluateIso2302(grpc::CallbackServerContext* context,
                                            const v1::EvaluateIso2302Request* request,
                                            v1::EvaluateIso2302Response* response) override {
    return evaluate(context, request, response, &standards::iso230_2);
  }
  grpc::ServerUnaryReactor* EvaluateIso2303(grpc::CallbackServerContext* context,
                                            const v1::EvaluateIso2303Request* request,
                                            v1::EvaluateIso2303Response* response) override {
    return evaluate(context, request, response, &standards::iso230_3);
  }
  grpc::ServerUnaryReactor* EvaluateIso9283(grpc::CallbackServerContext* context,
                                            const v1::EvaluateIso9283Request* request,
                                            v1::EvaluateIso9283Response* response) override {
    return evaluate(context, request, response, &standards::iso9283);
  }

 private:
  // The runs as they are exported, so that a file's figures and the daemon's are the same numbers.
  template <class Request, class Response, class Figures>
  grpc::ServerUnaryReactor* evaluate(grpc::CallbackServerContext* context, const Request* request,
                                     Response* response, Figures figures_of) {
    return answer(
        host_, context, [this, request, response, figures_of]() -> Awaitable<Result<void>> {
          DRIFTWISE_CO_TRY(auto runs, run_ids_from(request->run_ids()));
          if (runs.empty())
            co_return fail(ErrorCode::invalid_argument, reasons::kNoRuns,
                           "run_ids: found none, expected at least one");
          // With the rows kept out, marked: no figures of their own, but where the next row came
          // from.
          auto exporting = datasets_.export_csv(std::move(runs), false);
          DRIFTWISE_CO_TRY(const auto csv, co_await std::move(exporting));
          const auto options = options_from(*request);
          DRIFTWISE_CO_TRY(const auto figures,
                           co_await application::run_on(
                               host_.background(),
                               [figures_of](const std::string& text, const auto& asked) {
                                 const auto dataset = formats::read_dataset_csv(text, "run");
                                 using Answer = decltype(figures_of(*dataset, asked));
                                 if (!dataset) return Answer(tl::unexpected(dataset.error()));
                                 return figures_of(*dataset, asked);
                               },
                               csv, options));
          put(figures, *response);
          co_return Result<void>{};
        });
  }

  application::Host& host_;
  application::Datasets& datasets_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_standards_service(const application::Services& cell) {
  return std::make_unique<StandardsService>(cell);
}

}  // namespace driftwise::rpc
