#include "server/web/web_site.h"

#include "server/application/plumbing/run_on.h"
#include "server/web/grpc_web_gateway.h"
#include "server/web/metrics.h"
#include "server/web/same_origin.h"
#include "server/web/security_headers.h"
#include "server/web/static_files.h"

namespace driftwise::web {
namespace {

namespace fs = std::filesystem;

class WebSite final : public HttpSite {
 public:
  explicit WebSite(WebSiteParts parts)
      : host_(parts.host),
        overview_(parts.overview),
        gateway_(parts.executor, parts.channel),
        files_(parts.root) {}

  std::variant<HttpResponse, std::size_t> admit(const HttpRequest& head) override {
    if (auto refused = refuse_foreign(head)) return std::move(*refused);
    if (head.path().starts_with("/driftwise.v1.")) return GrpcWebGateway::admit(head);
    if (head.method == "GET" || head.method == "HEAD") return std::size_t{0};
    HttpResponse refused = plain_answer(405, "only GET and HEAD are answered here\n");
    refused.headers.push_back({"Allow", "GET, HEAD"});
    return refused;
  }

  Awaitable<HttpResponse> answer(HttpRequest request) override {
    if (request.method == "POST") co_return gateway_.open(std::move(request));
    if (request.path() == "/healthz") {
      co_await application::run_on(host_.executor(), [] {});
      co_return plain_answer(200, "ok\n");
    }
    if (request.path() != "/metrics") co_return files_.answer(request);
    const auto status =
        co_await application::run_on(host_.executor(), [this] { return overview_.status(); });
    HttpResponse response = plain_answer(200, metrics_text(status));
    response.headers.front().value = "text/plain; version=0.0.4; charset=utf-8";
    co_return response;
  }

 private:
  const application::Host& host_;
  const application::Overview& overview_;
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
