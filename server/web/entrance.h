#pragma once
// Who stands behind a request, and the page's log-in: /session.
//
//   GET    who the browser is: {"state": "in" | "out" | "open", "name", "role", "ends", "message"}
//   POST   {"token": "dwt_..."} or {"link": "dwl_..."}: begins a session, sets its cookie
//   DELETE ends it
//
// Three proofs count: "Authorization: Bearer dwt_...", the cookie of a session, and on a plain door
// with [access] loopback = "open" none at all. The cookie cannot be read by scripts, goes to no
// other site, and counts for a command only where the browser says that our own page sends it.
// Wrong tokens and links are slowed and counted by the authoriser. A session lasts no longer than
// the token or certificate behind it: of a link, that of whoever asked for it.
//
// Thread: the web thread; what takes long (scrypt) runs on the host's background thread.

#include <optional>
#include <string>

#include "server/access/access.h"
#include "server/application/ports/host.h"
#include "server/web/http_message.h"
#include "server/web/session_desk.h"

namespace driftwise::web {

struct Visitor {
  std::optional<access::Identity> identity;  // nothing: open
  bool open = false;                         // nobody has to prove anything at this door
  std::string session;                       // the cookie behind the identity; empty: none
};

class Entrance {
 public:
  static constexpr std::size_t kMostBody = 4096;

  struct Parts {
    access::Access& access;         // outlives this, as
    const application::Host& host;  // does this
    bool secure = false;            // the door speaks TLS
    std::uint16_t port = 0;         // part of the cookie's name: cookies know no ports
  };
  explicit Entrance(Parts parts);

  // Without waiting: somebody known, or an open door. False also for a token that was not checked
  // since the start: visitor() checks it.
  bool trusts(const HttpRequest& head);
  static bool shows_token(const HttpRequest& head);
  // Errors: unauthenticated NO_IDENTITY (what to do), BAD_TOKEN; resource_exhausted TOO_MANY_TRIES.
  // The request outlives the wait.
  Awaitable<Result<Visitor>> visitor(const HttpRequest& request);
  Awaitable<HttpResponse> session(HttpRequest request);
  // A stream that was begun in a session asks this: false from its end on.
  bool lasts(const std::string& session);

 private:
  const SessionDesk::Session* session_of(const HttpRequest& request);
  void end_revoked(SessionDesk::Instant now);
  bool is_open() const;
  Awaitable<Result<access::Identity>> by_token(std::string token, std::string peer);
  Awaitable<Result<access::Identity>> by_link(std::string link, std::string peer);
  Awaitable<HttpResponse> log_in(HttpRequest request);
  HttpResponse log_out(const HttpRequest& request);
  HttpResponse tell(const HttpRequest& request);
  std::string set_cookie(const std::string& value, std::int64_t age_s) const;

  Parts parts_;
  std::string cookie_name_;
  SessionDesk desk_;
  SessionDesk::Instant looked_{};
};

// 401, 403 or 429 by the error's code, with its sentence.
HttpResponse refused_answer(const Error& error);

}  // namespace driftwise::web
