#include "server/web/entrance.h"

#include <nlohmann/json.hpp>

#include "server/access/bearer.h"
#include "server/application/plumbing/run_on.h"
#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/core/try.h"
#include "server/web/same_origin.h"
#include "server/web/security_headers.h"

namespace driftwise::web {
namespace {

using Json = nlohmann::ordered_json;
using std::chrono::seconds;
constexpr seconds kLookAtProofs{1};

HttpResponse json_answer(int status, const Json& json) {
  HttpResponse response =
      plain_answer(status, json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
  response.headers.front().value = "application/json";
  return response;
}

HttpResponse refused_json(const Error& error) {
  HttpResponse response = refused_answer(error);
  response.body = Json{{"reason", error.reason}, {"message", error.message}}.dump(
                      -1, ' ', false, Json::error_handler_t::replace) +
                  "\n";
  response.headers.front().value = "application/json";
  return response;
}

std::string bearer_of(const HttpRequest& request) {
  return std::string(access::bearer_in(request.header("authorization")));
}

Json json_of(const SessionDesk::Session& session) {
  const auto left = session.ends - std::chrono::steady_clock::now();
  const auto ends = std::chrono::system_clock::now() + left;
  const CellTime utc{std::chrono::duration_cast<seconds>(ends.time_since_epoch()).count() *
                     1'000'000'000};
  return {{"state", "in"},
          {"name", session.who.name},
          {"role", access::to_string(session.who.role)},
          {"ends", to_iso8601(utc)}};
}

Error nobody(bool had_session) {
  return {ErrorCode::unauthenticated, reasons::kNoIdentity,
          std::string(had_session ? "the session has ended" : "nobody is logged in here") +
              ": log in with a token, or open the page with `driftwise open` on the measuring "
              "computer"};
}

Error ended_proof(const access::Identity& who) {
  const bool certificate = !who.certificate_pem.empty();
  return {ErrorCode::unauthenticated,
          certificate ? reasons::kCertificateRevoked : reasons::kBadToken,
          std::string("the ") + (certificate ? "certificate" : "token") + " of '" + who.name +
              "' was revoked or has ended: no session begins with it. Log in with another one; an "
              "admin makes it ('" +
              (certificate ? "driftwise cert client" : "driftwise token create") + "')"};
}

}  // namespace

HttpResponse refused_answer(const Error& error) {
  const int status = error.code == ErrorCode::unauthenticated      ? 401
                     : error.code == ErrorCode::resource_exhausted ? 429
                     : error.code == ErrorCode::invalid_argument   ? 400
                                                                   : 403;
  HttpResponse response = plain_answer(status, error.message + "\n");
  if (status == 401) response.headers.push_back({"WWW-Authenticate", "Bearer"});
  if (status == 429) response.headers.push_back({"Retry-After", "1"});
  return response;
}

Entrance::Entrance(Parts parts)
    : parts_(parts),
      // The prefix is the browser's: such a cookie is of this host alone and only for TLS.
      cookie_name_((parts.secure ? "__Host-driftwise-" : "driftwise-") +
                   std::to_string(parts.port)),
      desk_({.longest =
                 seconds(static_cast<std::int64_t>(parts.access.description().session_h * 3600))}) {
}

bool Entrance::is_open() const {
  return !parts_.secure && parts_.access.description().loopback == LoopbackRule::open;
}

const SessionDesk::Session* Entrance::session_of(const HttpRequest& request) {
  const auto cookie = cookie_value(request.header("cookie"), cookie_name_);
  if (cookie.empty()) return nullptr;
  // A browser lends its cookie to whoever makes it send something; it says who that is.
  if (is_command(request) && request.header("origin").empty() &&
      request.header("sec-fetch-site") != "same-origin")
    return nullptr;
  const auto now = std::chrono::steady_clock::now();
  end_revoked(now);
  return desk_.find(cookie, now);
}

void Entrance::end_revoked(SessionDesk::Instant now) {
  if (now - looked_ < kLookAtProofs) return;
  looked_ = now;
  desk_.end_unless(
      [this](const access::Identity& who) { return parts_.access.authoriser().in_force(who); });
}

bool Entrance::lasts(const std::string& session) {
  const auto now = std::chrono::steady_clock::now();
  end_revoked(now);
  return desk_.find(session, now) != nullptr;
}

bool Entrance::trusts(const HttpRequest& head) {
  if (const std::string bearer = bearer_of(head); !bearer.empty())
    return parts_.access.authoriser().knows(bearer);
  return session_of(head) != nullptr || is_open();
}

bool Entrance::shows_token(const HttpRequest& head) { return !bearer_of(head).empty(); }

Awaitable<Result<access::Identity>> Entrance::by_token(std::string token, std::string peer) {
  access::Evidence evidence;
  evidence.door = parts_.secure ? access::Door::tls : access::Door::loopback;
  evidence.from = std::move(peer);
  evidence.bearer = std::move(token);
  access::Authoriser* authoriser = &parts_.access.authoriser();
  if (authoriser->knows(evidence.bearer)) co_return authoriser->identify(evidence);
  co_return co_await application::run_on(
      parts_.host.background(),
      [authoriser](access::Evidence& what) { return authoriser->identify(what); },
      std::move(evidence));
}

Awaitable<Result<access::Identity>> Entrance::by_link(std::string link, std::string peer) {
  if (auto who = parts_.access.links().use(link, std::chrono::steady_clock::now()))
    co_return std::move(*who);
  // As a token it is wrong too: so the try is slowed, counted and told like any other.
  auto checking = by_token(std::move(link), std::move(peer));
  auto refused = co_await std::move(checking);
  if (!refused && refused.error().code == ErrorCode::resource_exhausted) co_return refused;
  co_return fail(ErrorCode::unauthenticated, reasons::kBadToken,
                 "this link was used before, or is older than two minutes: `driftwise open` on the "
                 "measuring computer makes another one");
}

Awaitable<Result<Visitor>> Entrance::visitor(const HttpRequest& request) {
  if (std::string bearer = bearer_of(request); !bearer.empty()) {
    auto checking = by_token(std::move(bearer), request.peer);
    DRIFTWISE_CO_TRY(auto who, co_await std::move(checking));
    co_return Visitor{std::move(who), false, {}};
  }
  if (const auto* session = session_of(request)) {
    Visitor out{session->who, false,
                std::string(cookie_value(request.header("cookie"), cookie_name_))};
    out.identity->from = request.peer;
    co_return out;
  }
  if (is_open()) co_return Visitor{std::nullopt, true, {}};
  co_return tl::unexpected(nobody(!cookie_value(request.header("cookie"), cookie_name_).empty()));
}

Awaitable<HttpResponse> Entrance::session(HttpRequest request) {
  if (request.method == "DELETE") co_return log_out(request);
  if (request.method != "POST") co_return tell(request);
  auto logging_in = log_in(std::move(request));
  co_return co_await std::move(logging_in);
}

Awaitable<HttpResponse> Entrance::log_in(HttpRequest request) {
  const auto json = Json::parse(request.body, nullptr, false);
  const auto text = [&json](const char* key) {
    const bool there = json.is_object() && json.contains(key) && json[key].is_string();
    return there ? json[key].get<std::string>().substr(0, 256) : std::string();
  };
  std::string token = text("token"), link = text("link");
  if (token.empty() == link.empty())
    co_return refused_json(
        {ErrorCode::invalid_argument, reasons::kBadToken,
         R"(expected {"token": "dwt_..."} or {"link": "dwl_..."}, one of them as a text)"});
  auto checking = link.empty() ? by_token(std::move(token), request.peer)
                               : by_link(std::move(link), request.peer);
  auto who = co_await std::move(checking);
  if (!who) co_return refused_json(who.error());
  // A link lives two minutes: what it was asked for with may have been revoked meanwhile.
  if (!parts_.access.authoriser().in_force(*who)) co_return refused_json(ended_proof(*who));
  const auto now = std::chrono::steady_clock::now();
  // The session of before ends: a browser has one.
  desk_.end(cookie_value(request.header("cookie"), cookie_name_));
  const std::string cookie = desk_.begin(std::move(*who), now);
  const auto* session = desk_.find(cookie, now);
  HttpResponse response = json_answer(200, json_of(*session));
  const auto age_s = std::chrono::duration_cast<seconds>(session->ends - now).count();
  response.headers.push_back({"Set-Cookie", set_cookie(cookie, age_s)});
  co_return response;
}

HttpResponse Entrance::log_out(const HttpRequest& request) {
  if (session_of(request)) desk_.end(cookie_value(request.header("cookie"), cookie_name_));
  HttpResponse response = tell(request);
  response.headers.push_back({"Set-Cookie", set_cookie("", 0)});
  return response;
}

HttpResponse Entrance::tell(const HttpRequest& request) {
  if (const auto* session = session_of(request)) return json_answer(200, json_of(*session));
  if (is_open()) return json_answer(200, {{"state", "open"}, {"role", "admin"}});
  const bool had_session = !cookie_value(request.header("cookie"), cookie_name_).empty();
  return json_answer(200, {{"state", "out"}, {"message", nobody(had_session).message}});
}

std::string Entrance::set_cookie(const std::string& value, std::int64_t age_s) const {
  return cookie_name_ + "=" + value + "; Path=/; Max-Age=" + std::to_string(age_s) +
         "; HttpOnly; SameSite=Strict" + (parts_.secure ? "; Secure" : "");
}

}  // namespace driftwise::web
