#pragma once
// A unary call that is answered by a service: from gRPC's thread to the executor's and back.
//
// work: a callable that makes an Awaitable<Result<void>>; it runs on the executor's thread, may
// fill the response, and what it captures lives until it is done (so a capturing lambda coroutine
// is safe here). The call's request, response and context live as long. When the client has gone in
// between, the work goes on: what was asked for stays asked for (StopAll halts a move), only the
// answer goes nowhere.

#include <grpcpp/server_context.h>

#include <exception>
#include <utility>

#include "server/application/ports/host.h"
#include "server/core/ports/spawn.h"
#include "server/rpc/shared/error_mapping.h"

namespace driftwise::rpc {

template <class Work>
Awaitable<void> run_and_finish(grpc::ServerUnaryReactor* reactor, Work work) {
  grpc::Status status;
  try {
    const Result<void> result = co_await work();
    if (!result) status = to_status(result.error());
  } catch (const std::exception& bug) {
    status = to_status(error_of_exception(bug));
  }
  reactor->Finish(status);
}

template <class Work>
grpc::ServerUnaryReactor* answer(const application::Host& host,
                                 grpc::CallbackServerContext* context, Work work) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  spawn(host.executor(), run_and_finish(reactor, std::move(work)));
  return reactor;
}

// A call that needs no executor: refused, or answered, at once.
inline grpc::ServerUnaryReactor* answer_now(grpc::CallbackServerContext* context,
                                            const Result<void>& result) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(result ? grpc::Status::OK : to_status(result.error()));
  return reactor;
}

}  // namespace driftwise::rpc
