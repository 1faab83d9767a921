#include "driftwise/v1/queue_service.grpc.pb.h"
#include "server/application/queue/queue.h"
#include "server/application/status/overview.h"
#include "server/core/try.h"
#include "server/rpc/queue/convert_queue.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

class QueueService final : public v1::QueueService::CallbackService {
 public:
  explicit QueueService(const application::Services& cell)
      : host_(cell.host), overview_(cell.overview), queue_(cell.queue) {}

  Reactor* ListQueue(Context* context, const v1::ListQueueRequest*,
                     v1::ListQueueResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      const auto view = queue_.list();
      for (const auto& line : view.lines)
        *response->add_entries() = queue_entry_from(line, host_.now());
      if (view.hold.held) *response->mutable_hold() = queue_hold_from(view.hold);
      co_return Result<void>{};
    });
  }

  Reactor* GetQueueEntry(Context* context, const v1::GetQueueEntryRequest* request,
                         v1::GetQueueEntryResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->entry_id(), "entry_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(const auto line, queue_.get({request->entry_id()}));
      *response->mutable_entry() = queue_entry_from(line, host_.now());
      response->set_trajectory_text(utf8_from(line.entry.trajectory_text));
      co_return Result<void>{};
    });
  }

  Reactor* AddQueueEntry(Context* context, const v1::AddQueueEntryRequest* request,
                         v1::AddQueueEntryResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto draft, queue_draft_from(*request, overview_.description().run));
      auto adding = queue_.add(caller_of(*context), std::move(draft));
      DRIFTWISE_CO_TRY(const auto line, co_await std::move(adding));
      *response->mutable_entry() = queue_entry_from(line, host_.now());
      co_return Result<void>{};
    });
  }

  Reactor* ChangeQueueEntry(Context* context, const v1::ChangeQueueEntryRequest* request,
                            v1::ChangeQueueEntryResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->entry_id(), "entry_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(auto edit, queue_edit_from(*request));
      auto changing = queue_.change(caller_of(*context), {request->entry_id()}, std::move(edit));
      DRIFTWISE_CO_TRY(const auto line, co_await std::move(changing));
      *response->mutable_entry() = queue_entry_from(line, host_.now());
      co_return Result<void>{};
    });
  }

  Reactor* MoveQueueEntry(Context* context, const v1::MoveQueueEntryRequest* request,
                          v1::MoveQueueEntryResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->entry_id(), "entry_id"); !good) co_return good;
      std::optional<QueueEntryId> before;
      if (request->has_before_entry_id()) {
        if (auto good = check_cursor(request->before_entry_id(), "before_entry_id"); !good)
          co_return good;
        before = QueueEntryId{request->before_entry_id()};
      }
      auto moving = queue_.move(caller_of(*context), {request->entry_id()}, before);
      DRIFTWISE_CO_TRY(const auto line, co_await std::move(moving));
      *response->mutable_entry() = queue_entry_from(line, host_.now());
      co_return Result<void>{};
    });
  }

  Reactor* RemoveQueueEntry(Context* context, const v1::RemoveQueueEntryRequest* request,
                            v1::RemoveQueueEntryResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->entry_id(), "entry_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(auto reason, line_from(request->reason(), kMostNameBytes, "reason"));
      auto removing = queue_.remove(caller_of(*context), {request->entry_id()}, std::move(reason));
      DRIFTWISE_CO_TRY(const auto line, co_await std::move(removing));
      *response->mutable_entry() = queue_entry_from(line, host_.now());
      co_return Result<void>{};
    });
  }

  Reactor* HoldQueue(Context* context, const v1::HoldQueueRequest* request,
                     v1::HoldQueueResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto reason, line_from(request->reason(), kMostNameBytes, "reason"));
      auto holding = queue_.hold(caller_of(*context), std::move(reason));
      DRIFTWISE_CO_TRY(const auto hold, co_await std::move(holding));
      *response->mutable_hold() = queue_hold_from(hold);
      co_return Result<void>{};
    });
  }

  Reactor* ReleaseQueue(Context* context, const v1::ReleaseQueueRequest*,
                        v1::ReleaseQueueResponse*) override {
    return answer(host_, context, [this, context]() -> Awaitable<Result<void>> {
      auto releasing = queue_.release(caller_of(*context));
      co_return co_await std::move(releasing);
    });
  }

 private:
  application::Host& host_;
  application::Overview& overview_;
  application::Queue& queue_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_queue_service(const application::Services& cell) {
  return std::make_unique<QueueService>(cell);
}

}  // namespace driftwise::rpc
