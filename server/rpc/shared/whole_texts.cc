#include "server/rpc/shared/whole_texts.h"

#include <algorithm>
#include <boost/asio/post.hpp>

#include "server/core/ports/spawn.h"
#include "server/core/reasons.h"
#include "server/rpc/shared/error_mapping.h"

namespace driftwise::rpc {
namespace {

Error busy(const char* what) {
  return {ErrorCode::resource_exhausted, reasons::kBusy,
          std::string(what) + "; ask again in a moment"};
}

}  // namespace

struct WholeTexts::Text::State {
  Making making;
  std::function<void()> wake;
  std::weak_ptr<WholeTexts> texts;
  std::string bytes;
  std::size_t sent = 0, whole_bytes = 0;
  std::optional<Result<void>> end;  // of the making, or of the text for the sake of others
  Instant since;                    // of the question, then of the last piece taken

  void stop(Result<void> why) {
    std::string().swap(bytes);
    sent = 0;
    end = std::move(why);
    if (wake) wake();
  }
};

WholeTexts::Text::~Text() {
  state_->wake = nullptr;
  std::string().swap(state_->bytes);
  if (const auto texts = state_->texts.lock()) texts->go_on_soon();
}

std::optional<std::string> WholeTexts::Text::next() {
  const std::size_t size = std::min(kPieceBytes, state_->bytes.size() - state_->sent);
  if (size == 0) return std::nullopt;
  std::string piece = state_->bytes.substr(state_->sent, size);
  state_->sent += size;
  state_->since = std::chrono::steady_clock::now();
  if (state_->sent == state_->bytes.size()) {
    std::string().swap(state_->bytes);
    state_->sent = 0;
    if (const auto texts = state_->texts.lock()) texts->go_on_soon();
  }
  return piece;
}

std::size_t WholeTexts::Text::bytes() const { return state_->whole_bytes; }
std::optional<Result<void>> WholeTexts::Text::ended() const { return state_->end; }

std::unique_ptr<WholeTexts::Text> WholeTexts::ask(Making making, std::function<void()> wake) {
  auto state = std::make_shared<Text::State>();
  state->making = std::move(making);
  state->wake = std::move(wake);
  state->texts = weak_from_this();
  state->since = std::chrono::steady_clock::now();
  waiting_.push_back(state);
  go_on_soon();
  return std::unique_ptr<Text>(new Text(std::move(state)));
}

std::size_t WholeTexts::held_bytes() const {
  std::size_t held = 0;
  for (const auto& one : made_)
    if (const auto text = one.lock()) held += text->bytes.size();
  return held;
}

void WholeTexts::go_on_soon() {
  boost::asio::post(executor_, [weak = weak_from_this()] {
    if (const auto alive = weak.lock()) alive->go_on();
  });
}

void WholeTexts::go_on() {
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(made_, [](const auto& one) {
    const auto text = one.lock();
    return !text || (text->end && text->bytes.empty());
  });
  std::erase_if(waiting_, [](const auto& one) { return one.expired(); });
  while (!making_ && !waiting_.empty()) {
    while (held_bytes() >= limits_.bytes)
      if (!end_stalled(now)) return look_again(now);
    making_ = true;
    spawn(executor_, run(shared_from_this(), waiting_.front().lock()));
    made_.splice(made_.end(), waiting_, waiting_.begin());
  }
}

// Of those that take nothing the one that has stood for longest.
bool WholeTexts::end_stalled(Instant now) {
  std::shared_ptr<Text::State> slowest;
  for (const auto& one : made_) {
    auto text = one.lock();
    if (!text || text->bytes.empty() || now - text->since < limits_.stalled) continue;
    if (!slowest || text->since < slowest->since) slowest = std::move(text);
  }
  if (!slowest) return false;
  slowest->stop(tl::unexpected(
      busy("this stream was not read for a while, and others needed the memory that its text "
           "held")));
  return true;
}

// What time alone changes: a text stalls, or the first that waits has waited too long.
void WholeTexts::look_again(Instant now) {
  while (!waiting_.empty()) {
    const auto first = waiting_.front().lock();
    if (first && now - first->since < limits_.patience) break;
    if (first)
      first->stop(
          tl::unexpected(busy("other streams hold the memory that there is for whole texts")));
    waiting_.pop_front();
  }
  if (waiting_.empty()) return;
  auto next = waiting_.front().lock()->since + limits_.patience;
  for (const auto& one : made_)
    if (const auto text = one.lock(); text && !text->bytes.empty())
      next = std::min(next, text->since + limits_.stalled);
  look_.expires_at(next);
  look_.async_wait([weak = weak_from_this()](boost::system::error_code cancelled) {
    const auto alive = weak.lock();
    if (!cancelled && alive) alive->go_on();
  });
}

Awaitable<void> WholeTexts::run(std::shared_ptr<WholeTexts> texts,
                                std::shared_ptr<Text::State> text) {
  Result<std::string> made;
  try {
    auto making = text->making();
    made = co_await std::move(making);
  } catch (const std::exception& bug) {
    made = tl::unexpected(error_of_exception(bug));
  }
  text->making = nullptr;
  texts->making_ = false;
  texts->go_on_soon();
  if (!text->wake) co_return;  // the client has gone
  if (!made) {
    text->stop(tl::unexpected(made.error()));
    co_return;
  }
  text->bytes = std::move(*made);
  text->whole_bytes = text->bytes.size();
  text->since = std::chrono::steady_clock::now();
  text->end = Result<void>{};
  text->wake();
}

}  // namespace driftwise::rpc
