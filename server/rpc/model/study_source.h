#pragma once
// A study as a stream: its latest progress, then its answer. Who leaves the stream ends the work.

#include <exception>
#include <functional>
#include <memory>
#include <optional>

#include "server/application/analyses/studies.h"
#include "server/rpc/shared/source_task.h"
#include "server/rpc/shared/stream.h"

namespace driftwise::rpc {

// Response: has a StudyProgress in its field `progress`; the one with the answer has none.
template <class Response>
class StudySource final : public StreamSource<Response> {
 public:
  using Carry = std::function<Awaitable<Result<Response>>(std::shared_ptr<application::Study>)>;

  StudySource(asio::any_io_executor executor, Carry carry)
      : executor_(std::move(executor)), carry_(std::move(carry)) {}
  ~StudySource() override {
    state_->wake = [] {};
    if (study_) study_->stop();
  }

  void start(std::function<void()> wake) override {
    state_->wake = std::move(wake);
    study_ = std::make_shared<application::Study>(
        [state = std::weak_ptr(state_)](const application::StudyProgress& progress) {
          const auto alive = state.lock();
          if (!alive || alive->end) return;
          auto& told = *alive->pending.emplace().mutable_progress();
          told.set_step(progress.step);
          told.set_fraction(progress.fraction);
          alive->wake();
        });
    spawn_for_source(executor_, carry_out(carry_, study_, state_), state_);
  }

  std::optional<Response> next() override { return std::exchange(state_->pending, std::nullopt); }
  std::optional<Result<void>> ended() override { return state_->end; }

 private:
  struct State {  // shared with the study, which may end after the client has gone
    std::optional<Response> pending;
    std::optional<Result<void>> end;
    std::function<void()> wake;
  };

  static Awaitable<void> carry_out(Carry carry, std::shared_ptr<application::Study> study,
                                   std::shared_ptr<State> state) {
    auto carrying = carry(std::move(study));
    auto answer = co_await std::move(carrying);
    if (answer) {
      state->pending = std::move(*answer);
      state->end = Result<void>{};
    } else {
      state->end = tl::unexpected(answer.error());
    }
    state->wake();
  }

  asio::any_io_executor executor_;
  Carry carry_;
  std::shared_ptr<application::Study> study_;
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace driftwise::rpc
