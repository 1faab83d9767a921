// Texts that are made whole and sent in pieces: the archive for support, the report of a run.

#include <algorithm>

#include "server/application/ports/host.h"
#include "server/application/report/reports.h"
#include "server/application/support/support_bundles.h"
#include "server/core/try.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/source_task.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using application::Host;
using application::SupportBundles;

constexpr std::size_t kPieceBytes = 64 * 1024;

using Making = std::function<Awaitable<Result<std::string>>()>;

struct WholeText {  // shared with the making, which may end after the client has gone
  Making making;
  std::string bytes;
  std::size_t sent = 0;
  std::optional<Result<void>> end;
  std::function<void()> wake;
};

Awaitable<void> make(std::shared_ptr<WholeText> state) {
  auto making = state->making();
  auto bytes = co_await std::move(making);
  if (bytes) {
    state->bytes = std::move(*bytes);
    state->end = Result<void>{};
  } else {
    state->end = tl::unexpected(bytes.error());
  }
  state->wake();
}

template <class Response>
class PieceSource final : public StreamSource<Response> {
 public:
  PieceSource(const Host& host, Making making) : host_(host) { state_->making = std::move(making); }
  ~PieceSource() override {
    state_->wake = [] {};
  }

  void start(std::function<void()> wake) override {
    state_->wake = std::move(wake);
    spawn_for_source(host_.executor(), make(state_), state_);
  }

  std::optional<Response> next() override {
    const std::size_t size = std::min(kPieceBytes, state_->bytes.size() - state_->sent);
    if (size == 0) return std::nullopt;
    Response response;
    response.set_data(state_->bytes.substr(state_->sent, size));
    state_->sent += size;
    return response;
  }
  std::optional<Result<void>> ended() override { return state_->end; }

 private:
  const Host& host_;
  std::shared_ptr<WholeText> state_ = std::make_shared<WholeText>();
};

Awaitable<Result<std::string>> page_of(application::Reports& reports, std::int64_t run) {
  DRIFTWISE_CO_RETURN_IF_ERROR(check_id(run, "run_id"));
  auto making = reports.page(RunId{run});
  co_return co_await std::move(making);
}

}  // namespace

std::unique_ptr<StreamSource<v1::GetSupportBundleResponse>> support_bundle(
    const Host& host, SupportBundles& bundles, application::Caller caller) {
  return std::make_unique<PieceSource<v1::GetSupportBundleResponse>>(
      host, [&bundles, caller = std::move(caller)] { return bundles.make(caller); });
}

std::unique_ptr<StreamSource<v1::GetReportResponse>> run_report(const Host& host,
                                                                application::Reports& reports,
                                                                std::int64_t run) {
  return std::make_unique<PieceSource<v1::GetReportResponse>>(
      host, [&reports, run] { return page_of(reports, run); });
}

}  // namespace driftwise::rpc
