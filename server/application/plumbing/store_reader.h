#pragma once
// The read-only store and its thread: queries never wait for the writer, and the writer never for a
// query.

#include <functional>
#include <memory>
#include <utility>

#include "server/application/plumbing/async_store.h"
#include "server/application/plumbing/run_on.h"
#include "server/core/try.h"

namespace driftwise::application {

class StoreReader : public AsyncStore {
 public:
  // open: makes the store anew after suspend(); empty: it cannot be suspended.
  using Open = std::function<Result<std::unique_ptr<Store>>()>;
  StoreReader(const asio::any_io_executor& executor, asio::any_io_executor thread,
              std::unique_ptr<Store> store, Open open = {})
      : AsyncStore(executor, std::move(thread), std::move(store)), open_(std::move(open)) {}

  // Later calls wait for resume(); when this returns, the calls made so far have their answers.
  Awaitable<void> hold() {
    if (!open_) co_return;
    suspended_ = true;
    co_await run_on(thread_, [] {});
  }
  // The same, and the connection is closed.
  Awaitable<void> suspend() {
    if (!open_) co_return;
    suspended_ = true;
    co_await run_on(thread_, [this] { store_.reset(); });
  }
  // Lets the calls go on, over another connection where it was closed. One that cannot be opened is
  // the error, and the calls wait for another resume().
  Awaitable<Result<void>> resume() {
    if (!open_ || !suspended_) co_return Result<void>{};
    const auto opened = co_await run_on(thread_, [this]() -> Result<void> {
      if (store_) return {};
      DRIFTWISE_TRY(store_, open_());
      return {};
    });
    suspended_ = !opened;
    if (opened) resumed_.raise();
    co_return opened;
  }
  bool suspended() const { return suspended_; }

 private:
  Open open_;
};

}  // namespace driftwise::application
