#pragma once
// One client's connection: requests in, answers out, one after the other, kept alive between them.
// The only file of the project whose source includes Boost.Beast.
//
// What a client may cost: 10 s until TLS is agreed, 16 KiB of headers within 10 s, a body of what
// the site admits within 5 min and never 20 s without a byte, 75 s of idleness, 60 s for each piece
// of the answer to leave. Beyond that the connection is closed, earlier where another client needs
// its place (door_quotas.h) or its memory (body_budget.h). TCP's keep-alive notices a vanished
// peer. A client that closes while its answer is still being made is noticed at once. One that
// sends its next request meanwhile is not watched any more until its answer is out.
//
// Thread: everything on the socket's executor, which is one thread.

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <memory>

#include "server/access/failed_handshakes.h"
#include "server/web/body_budget.h"
#include "server/web/door_quotas.h"
#include "server/web/http_message.h"

namespace driftwise::web {

class HttpConnection {
 public:
  // site, budget and failed (told of TLS that was not agreed) outlive the connection. tls: null for
  // a plain one.
  static std::shared_ptr<HttpConnection> make(asio::ip::tcp::socket socket,
                                              std::shared_ptr<asio::ssl::context> tls,
                                              HttpSite& site, BodyBudget& budget,
                                              access::FailedHandshakes& failed);
  virtual ~HttpConnection() = default;

  // Until the connection is over. The caller keeps it alive meanwhile.
  virtual Awaitable<void> serve() = 0;
  virtual ConnectionState state() const = 0;
  virtual bool closing() const = 0;  // it was told to close, and is on its way out
  virtual void end_soon() = 0;       // at once when idle, else after the present answer
  virtual void close() = 0;          // at once: the answer under way is abandoned
};

}  // namespace driftwise::web
