#include "server/web/web_site.h"

#include <algorithm>
#include <charconv>

#include "server/application/plumbing/run_on.h"
#include "server/core/reasons.h"
#include "server/web/entrance.h"
#include "server/web/grpc_web_gateway.h"
#include "server/web/metrics.h"
#include "server/web/request_rate.h"
#include "server/web/same_origin.h"
#include "server/web/security_headers.h"
#include "server/web/static_files.h"
#include "server/web/stop_socket.h"

namespace driftwise::web {
namespace {

namespace fs = std::filesystem;

// Of bodies of clients that nobody knows yet: room for a log-in, not for a dataset.
constexpr std::size_t kMostUnknownBody = 64 * 1024;

std::string address_of(const std::string& peer) { return peer.substr(0, peer.rfind(':')); }

class WebSite final : public HttpSite {
 public:
  explicit WebSite(WebSiteParts parts)
      : host_(parts.host),
        overview_(parts.overview),
        access_(parts.access),
        entrance_({parts.access, parts.host, parts.secure, parts.port}),
        gateway_(parts.executor, parts.channel),
        files_(parts.root) {}

  Awaitable<Admitted> admit(const HttpRequest& head) override { return admit_head(head); }

 private:
  Awaitable<Admitted> admit_head(const HttpRequest& head) {
    if (auto refused = refuse_foreign(head, access_.description().names))
      co_return std::move(*refused);
    const bool trusted = entrance_.trusts(head);
    if (!trusted && !rate_.takes(address_of(head.peer), std::chrono::steady_clock::now()))
      co_return refused_answer({ErrorCode::resource_exhausted, reasons::kTooManyTries,
                                "too many requests from this address before a log-in: try again "
                                "in a second"});
    if (asks_for_socket(head)) {
      auto refused = refuse_socket(head);
      co_return refused ? Admitted(std::move(*refused)) : Admitted(std::size_t{0});
    }
    if (head.path() == kSession) co_return admit_session(head);
    if (head.path().starts_with("/driftwise.v1.")) {
      auto admitted = GrpcWebGateway::admit(head);
      auto* most = std::get_if<std::size_t>(&admitted);
      if (most == nullptr || trusted || !exceeds_unknown(head)) co_return admitted;
      if (!Entrance::shows_token(head)) {
        *most = std::min(*most, kMostUnknownBody);
        co_return admitted;
      }
      // The token is looked at before its body is judged: it may be good, and new to us.
      auto asking = entrance_.visitor(head);
      const auto visitor = co_await std::move(asking);
      if (!visitor) co_return refused_answer(visitor.error());
      co_return admitted;
    }
    if (head.method == "GET" || head.method == "HEAD") co_return std::size_t{0};
    HttpResponse refused = plain_answer(405, "only GET and HEAD are answered here\n");
    refused.headers.push_back({"Allow", "GET, HEAD"});
    co_return refused;
  }

 public:
  Awaitable<HttpResponse> answer(HttpRequest request) override {
    if (request.path() == kSession) {
      auto answering = entrance_.session(std::move(request));
      co_return co_await std::move(answering);
    }
    if (asks_for_socket(request)) {
      auto stopping = stop(std::move(request));
      co_return co_await std::move(stopping);
    }
    if (request.method == "POST") {
      auto calling = call(std::move(request));
      co_return co_await std::move(calling);
    }
    if (request.path() == "/healthz") {
      co_await application::run_on(host_.executor(), [] {});
      co_return plain_answer(200, "ok\n");
    }
    if (request.path() != "/metrics") co_return files_.answer(request);
    auto telling = metrics(std::move(request));
    co_return co_await std::move(telling);
  }

 private:
  static constexpr std::string_view kSession = "/session";

  // Its body may be larger than what is read of somebody unknown; one in chunks does not say.
  static bool exceeds_unknown(const HttpRequest& head) {
    const std::string_view length = head.header("content-length");
    std::size_t bytes = 0;
    const auto [end, bad] = std::from_chars(length.data(), length.data() + length.size(), bytes);
    return length.empty() || bad != std::errc{} || bytes > kMostUnknownBody;
  }

  static Admitted admit_session(const HttpRequest& head) {
    if (head.method == "GET" || head.method == "DELETE") return std::size_t{0};
    if (head.method != "POST") {
      HttpResponse refused = plain_answer(405, "GET, POST and DELETE are answered here\n");
      refused.headers.push_back({"Allow", "GET, POST, DELETE"});
      return refused;
    }
    // Forms of other pages cannot send it without being asked for leave; there is none.
    if (!head.header("content-type").starts_with("application/json"))
      return plain_answer(415, "Content-Type: expected application/json\n");
    return Entrance::kMostBody;
  }

  Awaitable<HttpResponse> call(HttpRequest request) {
    auto asking = entrance_.visitor(request);
    auto visitor = co_await std::move(asking);
    if (!visitor) co_return GrpcWebGateway::refuse(request, visitor.error());
    GrpcWebGateway::Behalf behalf;
    if (visitor->identity) behalf.vouched = access_.authoriser().vouch(*visitor->identity);
    if (!visitor->session.empty())
      behalf.lasts = [this, session = visitor->session] { return entrance_.lasts(session); };
    co_return gateway_.open(std::move(request), std::move(behalf));
  }

  Awaitable<HttpResponse> stop(HttpRequest request) {
    const std::string key(request.header("sec-websocket-key"));
    auto calling = call(call_of_socket(std::move(request)));
    HttpResponse answer = co_await std::move(calling);
    co_return socket_answer(std::move(answer), key);
  }

  Awaitable<HttpResponse> metrics(HttpRequest request) {
    auto asking = entrance_.visitor(request);
    const auto visitor = co_await std::move(asking);
    if (!visitor) co_return refused_answer(visitor.error());
    if (visitor->identity)
      if (const auto may = access_.authoriser().authorise(*visitor->identity,
                                                          {"/metrics", access::Role::viewer});
          !may)
        co_return refused_answer(may.error());
    const auto status =
        co_await application::run_on(host_.executor(), [this] { return overview_.status(); });
    HttpResponse response = plain_answer(200, metrics_text(status));
    response.headers.front().value = "text/plain; version=0.0.4; charset=utf-8";
    co_return response;
  }

  const application::Host& host_;
  const application::Overview& overview_;
  access::Access& access_;
  Entrance entrance_;
  RequestRate rate_;
  GrpcWebGateway gateway_;
  StaticFiles files_;
};

}  // namespace

std::unique_ptr<HttpSite> make_web_site(WebSiteParts parts) {
  return std::make_unique<WebSite>(std::move(parts));
}

fs::path find_web_root(const std::string& asked) {
  if (!asked.empty()) return asked;
  std::error_code failed;
  const fs::path program = fs::read_symlink("/proc/self/exe", failed).parent_path();
  if (failed) return {};
  for (const char* place :
       {"../share/driftwise/web", "../clients/web/dist", "../../../clients/web/dist"})
    if (const fs::path root = program / place; fs::is_regular_file(root / "index.html", failed))
      return root.lexically_normal();
  return {};
}

}  // namespace driftwise::web
