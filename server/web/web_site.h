#pragma once
// What is to be found at the daemon's web address: the page's files, /session, the calls of the API
// as gRPC-Web, /healthz, /metrics.
//
// Anybody gets the page's files and /healthz, which hold nothing of the cell. All else needs
// somebody known (entrance.h); what exists and what does not is refused alike before that.

#include <grpcpp/channel.h>

#include <filesystem>
#include <memory>

#include "server/access/access.h"
#include "server/application/ports/host.h"
#include "server/application/status/overview.h"
#include "server/web/http_message.h"

namespace driftwise::web {

struct WebSiteParts {
  const application::Host& host;           // outlives the site, as
  const application::Overview& overview;   // does this
  std::shared_ptr<grpc::Channel> channel;  // to the services, inside the process
  std::filesystem::path root;              // with index.html; empty: no page
  asio::any_io_executor executor;          // the web thread
  access::Access& access;                  // outlives the site
  bool secure = false;                     // the door speaks TLS
  std::uint16_t port = 0;                  // of the door
};

// /healthz answers "ok" when the cell's executor does: a daemon that hangs does not look healthy.
std::unique_ptr<HttpSite> make_web_site(WebSiteParts parts);

// asked, when it is not empty; else the page that was installed or built with this program
// (../share/driftwise/web, or clients/web/dist of the source tree beside the build); else empty.
std::filesystem::path find_web_root(const std::string& asked);

}  // namespace driftwise::web
