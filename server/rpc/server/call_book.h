#pragma once
// The calls that are open at the gRPC door, by connection: which connections are idle, and which
// stream makes room when there are too many.
//
// An interceptor enters each call but single targets, whose path stays as short as it was, and
// those that the guard has refused. A stream beyond the quotas ends another one: first of those
// that nobody known has begun (health and reflection answer everybody), so that a stranger ends
// strangers' streams only. Among equals the slowest goes: the one whose client has not taken a
// message for longest, else the one without a message for longest. A new stream is always let in,
// as a new page must be; unary calls (a stop) are not counted. Any thread.

#include <grpcpp/support/server_interceptor.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace driftwise::rpc {

class CallBook {
 public:
  using Instant = std::chrono::steady_clock::time_point;
  struct Quotas {
    std::size_t streams_in_all = 512;
    std::size_t streams_per_connection = 64;
  };
  // A stream that blocks for less than this is not slow.
  static constexpr std::chrono::seconds kSlow{1};

  CallBook() : CallBook(Quotas{}) {}
  explicit CallBook(Quotas quotas);
  ~CallBook();
  CallBook(const CallBook&) = delete;
  CallBook& operator=(const CallBook&) = delete;

  struct Call {
    std::string peer;  // access/peer_name.h; empty: the web gateway, inside the process
    bool is_stream = false;
    bool is_known = false;  // the guard has let it in: somebody stands behind it
    // What tells its connection from others of the same name, as unix clients have one; it is
    // compared, never looked into. Null: the name does.
    const void* connection = nullptr;
  };
  // end: cancels the call; it is called with the book's lock held, on the thread of whoever needs
  // the room.
  class Entry;
  std::unique_ptr<Entry> enter(Call call, std::function<void()> end);

  // Ends every stream, those that begin later at once: the door closes.
  void end_streams();

  // Of somebody known: whoever only asks for health holds no connection against people.
  std::size_t known_calls(const std::string& peer) const;
  std::size_t streams() const;

 private:
  struct Calls;
  std::shared_ptr<Calls> calls_;
};

// One open call; it leaves the book when it goes.
class CallBook::Entry {
 public:
  Entry(std::shared_ptr<Calls> calls, std::size_t id) : calls_(std::move(calls)), id_(id) {}
  ~Entry();
  Entry(const Entry&) = delete;
  Entry& operator=(const Entry&) = delete;

  void message_begun();  // to be written
  void message_taken();

 private:
  std::shared_ptr<Calls> calls_;
  std::size_t id_;
};

// Enters every call of a server into the book. To be the first of the server's interceptors.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> entering(
    std::shared_ptr<CallBook> book);

}  // namespace driftwise::rpc
