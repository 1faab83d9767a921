// The archive for support and the report of a run, in pieces.

#include "server/application/report/reports.h"
#include "server/application/support/support_bundles.h"
#include "server/core/try.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

Awaitable<Result<std::string>> page_of(application::Reports& reports, std::int64_t run) {
  DRIFTWISE_CO_RETURN_IF_ERROR(check_id(run, "run_id"));
  auto making = reports.page(RunId{run});
  co_return co_await std::move(making);
}

template <class Response>
std::unique_ptr<StreamSource<Response>> in_pieces(std::shared_ptr<WholeTexts> texts,
                                                  WholeTexts::Making making) {
  return std::make_unique<WholeTextSource<Response>>(
      std::move(texts), std::move(making), [](Response& response, std::string piece, std::size_t) {
        response.set_data(std::move(piece));
      });
}

}  // namespace

std::unique_ptr<StreamSource<v1::GetSupportBundleResponse>> support_bundle(
    std::shared_ptr<WholeTexts> texts, application::SupportBundles& bundles,
    application::Caller caller) {
  return in_pieces<v1::GetSupportBundleResponse>(
      std::move(texts), [&bundles, caller = std::move(caller)] { return bundles.make(caller); });
}

std::unique_ptr<StreamSource<v1::GetReportResponse>> run_report(std::shared_ptr<WholeTexts> texts,
                                                                application::Reports& reports,
                                                                std::int64_t run) {
  return in_pieces<v1::GetReportResponse>(std::move(texts),
                                          [&reports, run] { return page_of(reports, run); });
}

}  // namespace driftwise::rpc
