#pragma once
// Texts that are made whole and sent in pieces: exports, reports, archives. All of them together
// have a budget of memory, so that clients which take nothing cost it once, not once each.
//
// They are made one after the other, in the order in which they were asked for, each when there is
// room for it. Where there is none, a text of which no piece was taken for Limits::stalled ends
// (RESOURCE_EXHAUSTED BUSY), and so does one that has waited for Limits::patience. What is held is
// at most Limits::bytes and one text more.
//
// Thread: the executor's. What is under way at the end of it is dropped.

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/core/ports/awaitable.h"
#include "server/core/result.h"
#include "server/rpc/shared/stream.h"

namespace driftwise::rpc {

class WholeTexts : public std::enable_shared_from_this<WholeTexts> {
 public:
  using Making = std::function<Awaitable<Result<std::string>>()>;
  using Instant = std::chrono::steady_clock::time_point;
  static constexpr std::size_t kPieceBytes = 64 * 1024;
  struct Limits {
    std::size_t bytes = std::size_t{32} << 20;
    std::chrono::milliseconds stalled{5'000}, patience{30'000};
  };

  static std::shared_ptr<WholeTexts> make(boost::asio::any_io_executor executor) {
    return make(std::move(executor), Limits{});
  }
  static std::shared_ptr<WholeTexts> make(boost::asio::any_io_executor executor, Limits limits) {
    return std::shared_ptr<WholeTexts>(new WholeTexts(std::move(executor), limits));
  }

  // One text for one client; its place and its memory are free when it goes.
  class Text {
   public:
    ~Text();
    Text(const Text&) = delete;
    Text& operator=(const Text&) = delete;
    std::optional<std::string> next();  // nothing: not yet, or no more
    std::size_t bytes() const;          // of the whole, once it is made
    std::optional<Result<void>> ended() const;

   private:
    friend class WholeTexts;
    struct State;
    explicit Text(std::shared_ptr<State> state) : state_(std::move(state)) {}
    std::shared_ptr<State> state_;
  };
  // wake: called when next() or ended() may have news, never from within this call.
  std::unique_ptr<Text> ask(Making making, std::function<void()> wake);

  std::size_t held_bytes() const;

 private:
  WholeTexts(boost::asio::any_io_executor executor, Limits limits)
      : executor_(std::move(executor)), limits_(limits), look_(executor_) {}
  void go_on();
  void go_on_soon();
  bool end_stalled(Instant now);
  void look_again(Instant now);
  static Awaitable<void> run(std::shared_ptr<WholeTexts> texts, std::shared_ptr<Text::State> text);

  boost::asio::any_io_executor executor_;
  Limits limits_;
  boost::asio::steady_timer look_;
  std::list<std::weak_ptr<Text::State>> waiting_, made_;  // the last of these: being made
  bool making_ = false;
};

// A stream of such a text. Fill: puts a piece, and the bytes of the whole, into a response.
template <class Response>
class WholeTextSource final : public StreamSource<Response> {
 public:
  using Fill = void (*)(Response& response, std::string piece, std::size_t whole_bytes);
  WholeTextSource(std::shared_ptr<WholeTexts> texts, WholeTexts::Making making, Fill fill)
      : texts_(std::move(texts)), making_(std::move(making)), fill_(fill) {}

  void start(std::function<void()> wake) override {
    text_ = texts_->ask(std::move(making_), std::move(wake));
  }
  std::optional<Response> next() override {
    auto piece = text_->next();
    if (!piece) return std::nullopt;
    Response response;
    fill_(response, std::move(*piece), text_->bytes());
    return response;
  }
  std::optional<Result<void>> ended() override { return text_->ended(); }

 private:
  std::shared_ptr<WholeTexts> texts_;
  WholeTexts::Making making_;
  Fill fill_;
  std::unique_ptr<WholeTexts::Text> text_;
};

}  // namespace driftwise::rpc
