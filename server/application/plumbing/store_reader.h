#pragma once
// The read-only store and its thread: queries never wait for the writer, and the writer never for a
// query.

#include <functional>
#include <memory>
#include <utility>

#include "server/application/plumbing/async_store.h"
#include "server/application/plumbing/run_on.h"

namespace driftwise::application {

class StoreReader : public AsyncStore {
 public:
  // open: makes the store anew after suspend(); empty: it cannot be suspended.
  using Open = std::function<Result<std::unique_ptr<Store>>()>;
  StoreReader(const asio::any_io_executor& executor, asio::any_io_executor thread,
              std::unique_ptr<Store> store, Open open = {})
      : AsyncStore(executor, std::move(thread), std::move(store)), open_(std::move(open)) {}

  // Closes the connection when the calls made so far have their answers; later calls wait for
  // resume(), which opens another one and tries until that can be done.
  Awaitable<void> suspend() {
    if (!open_) co_return;
    suspended_ = true;
    co_await run_on(thread_, [this] { store_.reset(); });
  }
  Awaitable<void> resume() {
    if (!open_ || !suspended_) co_return;
    suspended_ = !co_await run_on(thread_, [this] {
      auto opened = open_();
      if (opened) store_ = std::move(*opened);
      return opened.has_value();
    });
    if (!suspended_) resumed_.raise();
  }
  bool suspended() const { return suspended_; }

 private:
  Open open_;
};

}  // namespace driftwise::application
