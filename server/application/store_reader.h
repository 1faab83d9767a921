#pragma once
// The read-only store and its thread: queries never wait for the writer, and the writer never for a
// query.

#include <memory>
#include <utility>

#include "server/application/signal.h"
#include "server/core/ports/store.h"

namespace driftwise::application {

class StoreReader {
 public:
  StoreReader(asio::any_io_executor thread, std::unique_ptr<Store> store)
      : thread_(std::move(thread)), store_(std::move(store)) {}

  template <class Function>
  auto call(Function function) {
    return run_on(thread_,
                  [store = store_.get(), f = std::move(function)]() mutable { return f(*store); });
  }

 private:
  asio::any_io_executor thread_;
  std::unique_ptr<Store> store_;
};

}  // namespace driftwise::application
