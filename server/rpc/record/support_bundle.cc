#include <algorithm>

#include "server/application/ports/host.h"
#include "server/application/support/support_bundles.h"
#include "server/core/ports/spawn.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using application::Host;
using application::SupportBundles;

constexpr std::size_t kPieceBytes = 64 * 1024;

struct BundleState {  // shared with the making, which may end after the client has gone
  std::string bytes;
  std::size_t sent = 0;
  std::optional<Result<void>> end;
  std::function<void()> wake;
};

Awaitable<void> make(SupportBundles& bundles, application::Caller caller,
                     std::shared_ptr<BundleState> state) {
  auto making = bundles.make(std::move(caller));
  auto bytes = co_await std::move(making);
  if (bytes) {
    state->bytes = std::move(*bytes);
    state->end = Result<void>{};
  } else {
    state->end = tl::unexpected(bytes.error());
  }
  state->wake();
}

class BundleSource final : public StreamSource<v1::GetSupportBundleResponse> {
 public:
  BundleSource(const Host& host, SupportBundles& bundles, application::Caller caller)
      : host_(host), bundles_(bundles), caller_(std::move(caller)) {}
  ~BundleSource() override {
    state_->wake = [] {};
  }

  void start(std::function<void()> wake) override {
    state_->wake = std::move(wake);
    spawn(host_.executor(), make(bundles_, caller_, state_));
  }

  std::optional<v1::GetSupportBundleResponse> next() override {
    const std::size_t size = std::min(kPieceBytes, state_->bytes.size() - state_->sent);
    if (size == 0) return std::nullopt;
    v1::GetSupportBundleResponse response;
    response.set_data(state_->bytes.substr(state_->sent, size));
    state_->sent += size;
    return response;
  }
  std::optional<Result<void>> ended() override { return state_->end; }

 private:
  const Host& host_;
  SupportBundles& bundles_;
  application::Caller caller_;
  std::shared_ptr<BundleState> state_ = std::make_shared<BundleState>();
};

}  // namespace

std::unique_ptr<StreamSource<v1::GetSupportBundleResponse>> support_bundle(
    const Host& host, SupportBundles& bundles, application::Caller caller) {
  return std::make_unique<BundleSource>(host, bundles, std::move(caller));
}

}  // namespace driftwise::rpc
