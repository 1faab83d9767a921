#pragma once
// The read-only store and its thread: queries never wait for the writer, and the writer never for a
// query.

#include <functional>
#include <memory>
#include <utility>

#include "server/application/plumbing/signal.h"
#include "server/core/ports/store.h"

namespace driftwise::application {

class StoreReader {
 public:
  // open: makes the store anew after suspend(); empty: it cannot be suspended.
  using Open = std::function<Result<std::unique_ptr<Store>>()>;
  StoreReader(asio::any_io_executor executor, asio::any_io_executor thread,
              std::unique_ptr<Store> store, Open open = {})
      : thread_(std::move(thread)),
        store_(std::move(store)),
        open_(std::move(open)),
        resumed_(executor) {}

  template <class Function>
  auto call(Function function) {
    return when_open(std::make_shared<Function>(std::move(function)));
  }

  // Closes the connection when the calls made so far have their answers; later calls wait for
  // resume(), which opens another one and tries until that can be done.
  Awaitable<void> suspend() {
    if (!open_) co_return;
    suspended_ = true;
    auto closing = run_on(thread_, [this] { store_.reset(); });
    co_await std::move(closing);
  }
  Awaitable<void> resume() {
    if (!open_ || !suspended_) co_return;
    auto opening = run_on(thread_, [this]() -> bool {
      auto opened = open_();
      if (opened) store_ = std::move(*opened);
      return opened.has_value();
    });
    suspended_ = !co_await std::move(opening);
    if (!suspended_) resumed_.raise();
  }
  bool suspended() const { return suspended_; }

 private:
  template <class Function>
  Awaitable<std::invoke_result_t<Function&, Store&>> when_open(std::shared_ptr<Function> function) {
    while (suspended_) co_await resumed_.wait();
    auto calling = run_on(thread_, [this, function] { return (*function)(*store_); });
    co_return co_await std::move(calling);
  }

  asio::any_io_executor thread_;
  std::unique_ptr<Store> store_;
  Open open_;
  bool suspended_ = false;
  Signal resumed_;
};

}  // namespace driftwise::application
