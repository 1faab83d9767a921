#include "server/rpc/server/call_book.h"

#include <grpcpp/server_context.h>

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "server/rpc/server/guard.h"
#include "server/rpc/shared/call_context.h"
#include "server/rpc/shared/caller.h"

namespace driftwise::rpc {

struct CallBook::Calls {
  struct One {
    Call call;
    bool blocked = false;
    Instant since;  // of the last message, or of its beginning
    std::function<void()> end;
  };
  // Ending a call may run callbacks on this thread that leave the book.
  mutable std::recursive_mutex mutex;
  Quotas quotas;
  std::map<std::size_t, One> open;
  std::size_t next_id = 0;
  bool closing = false;

  // Ends the first stream to go, of one connection or of all.
  void end_slowest(const Call* of_connection) {
    const auto now = std::chrono::steady_clock::now();
    std::optional<std::size_t> slowest;
    const auto rank = [&](const One& one) {
      return std::tuple(one.call.is_known, !(one.blocked && now - one.since >= kSlow), one.since);
    };
    for (const auto& [id, one] : open) {
      if (!is_open_stream(one) || (of_connection && !same(one.call, *of_connection))) continue;
      if (!slowest || rank(one) < rank(open.at(*slowest))) slowest = id;
    }
    if (!slowest) return;
    const auto end = std::exchange(open.at(*slowest).end, nullptr);
    end();
  }

  std::size_t streams(const Call* of_connection) const {
    std::size_t count = 0;
    for (const auto& [id, one] : open)
      count += is_open_stream(one) && (!of_connection || same(one.call, *of_connection)) ? 1 : 0;
    return count;
  }

  static bool is_open_stream(const One& one) { return one.call.is_stream && one.end; }
  static bool same(const Call& a, const Call& b) {
    return a.peer == b.peer && a.connection == b.connection;
  }
};

CallBook::CallBook(Quotas quotas) : calls_(std::make_shared<Calls>()) { calls_->quotas = quotas; }
CallBook::~CallBook() = default;

std::unique_ptr<CallBook::Entry> CallBook::enter(Call call, std::function<void()> end) {
  const std::lock_guard lock(calls_->mutex);
  if (call.is_stream) {
    // The page's streams come through the gateway, whose own door holds them within bounds.
    const bool from_socket = !call.peer.empty();
    if (from_socket && calls_->streams(&call) >= calls_->quotas.streams_per_connection)
      calls_->end_slowest(&call);
    if (calls_->streams(nullptr) >= calls_->quotas.streams_in_all) calls_->end_slowest(nullptr);
  }
  if (call.is_stream && calls_->closing) std::exchange(end, nullptr)();
  const std::size_t id = calls_->next_id++;
  calls_->open.emplace(
      id, Calls::One{std::move(call), false, std::chrono::steady_clock::now(), std::move(end)});
  return std::make_unique<Entry>(calls_, id);
}

void CallBook::end_streams() {
  const std::lock_guard lock(calls_->mutex);
  calls_->closing = true;
  // Ending one may take others out of the book.
  std::vector<std::size_t> ids;
  for (const auto& [id, one] : calls_->open)
    if (Calls::is_open_stream(one)) ids.push_back(id);
  for (const std::size_t id : ids)
    if (const auto one = calls_->open.find(id); one != calls_->open.end())
      if (const auto end = std::exchange(one->second.end, nullptr)) end();
}

std::size_t CallBook::known_calls(const std::string& peer) const {
  const std::lock_guard lock(calls_->mutex);
  std::size_t count = 0;
  for (const auto& [id, one] : calls_->open)
    count += one.call.is_known && one.call.peer == peer ? 1 : 0;
  return count;
}

std::size_t CallBook::streams() const {
  const std::lock_guard lock(calls_->mutex);
  return calls_->streams(nullptr);
}

CallBook::Entry::~Entry() {
  const std::lock_guard lock(calls_->mutex);
  calls_->open.erase(id_);
}

void CallBook::Entry::message_begun() {
  const std::lock_guard lock(calls_->mutex);
  auto& one = calls_->open.at(id_);
  one.blocked = true;
  one.since = std::chrono::steady_clock::now();
}

void CallBook::Entry::message_taken() {
  const std::lock_guard lock(calls_->mutex);
  auto& one = calls_->open.at(id_);
  one.blocked = false;
  one.since = std::chrono::steady_clock::now();
}

namespace {

namespace gx = grpc::experimental;

// What is one for each connection, for as long as one of its calls is open: gRPC makes the facts of
// a connection at its handshake and keeps them for all of its calls, so their place in memory tells
// connections apart where their names do not. Null: it has none.
const void* connection_of(const grpc::ServerContextBase& context) {
  const auto facts = context.auth_context();
  if (!facts) return nullptr;
  const auto kinds = facts->FindPropertyValues("transport_security_type");
  return kinds.empty() ? nullptr : kinds.front().data();
}

// Cancelling a call goes through all of its interceptors, on another thread. So it enters the book
// when the last of them is made, and as the first of them it is the first to go, out of the book.
class Entering final : public gx::Interceptor {
 public:
  Entering(std::shared_ptr<CallBook> book, grpc::ServerContextBase& context, bool is_stream)
      : book_(std::move(book)), context_(context), is_stream_(is_stream) {}
  void Intercept(gx::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(gx::InterceptionHookPoints::POST_RECV_INITIAL_METADATA))
      enter();
    if (entry_ && methods->QueryInterceptionHookPoint(gx::InterceptionHookPoints::PRE_SEND_MESSAGE))
      entry_->message_begun();
    if (entry_ &&
        methods->QueryInterceptionHookPoint(gx::InterceptionHookPoints::POST_SEND_MESSAGE))
      entry_->message_taken();
    methods->Proceed();
  }

 private:
  void enter() {
    // Whoever may not call takes nobody's place.
    const auto* call = dynamic_cast<const CallContext*>(&context_);
    if (entry_ || (call != nullptr && call->refused())) return;
    CallBook::Call entered;
    entered.is_stream = is_stream_;
    entered.is_known = call != nullptr && call->who();
    if (!from_inside(context_)) {
      entered.peer = peer_of(context_);
      if (is_stream_) entered.connection = connection_of(context_);
    }
    entry_ = book_->enter(std::move(entered), [&context = context_] { context.TryCancel(); });
  }

  std::shared_ptr<CallBook> book_;
  grpc::ServerContextBase& context_;
  bool is_stream_;
  std::unique_ptr<CallBook::Entry> entry_;
};

class EnteringFactory final : public gx::ServerInterceptorFactoryInterface {
 public:
  explicit EnteringFactory(std::shared_ptr<CallBook> book) : book_(std::move(book)) {}
  gx::Interceptor* CreateServerInterceptor(gx::ServerRpcInfo* info) override {
    if (info->method() != nullptr && info->method() == kComputeTarget) return nullptr;
    const bool is_stream = info->type() == gx::ServerRpcInfo::Type::SERVER_STREAMING ||
                           info->type() == gx::ServerRpcInfo::Type::BIDI_STREAMING;
    return new Entering(book_, *info->server_context(), is_stream);
  }

 private:
  std::shared_ptr<CallBook> book_;
};

}  // namespace

std::unique_ptr<gx::ServerInterceptorFactoryInterface> entering(std::shared_ptr<CallBook> book) {
  return std::make_unique<EnteringFactory>(std::move(book));
}

}  // namespace driftwise::rpc
