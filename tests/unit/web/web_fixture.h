#pragma once
// The web door as a browser meets it: a real HTTP server on a free port before a gRPC server over a
// real cell, and a folder of files.

#include <gmock/gmock.h>

#include <filesystem>
#include <stdexcept>

#include "server/rpc/server/rpc_server.h"
#include "server/web/http_server.h"
#include "server/web/web_site.h"
#include "tests/support/fakes.h"
#include "tests/support/http_client.h"
#include "tests/support/process.h"

namespace driftwise::tests {

class WebTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto services = cell.services(fakes);
    auto entering = access::Access::open(description(), folder.path());
    if (!entering) throw std::runtime_error(entering.error().message);
    access = std::move(*entering);
    auto opened = rpc::RpcServer::open(services, "127.0.0.1:0", {}, access.get());
    if (!opened) throw std::runtime_error(opened.error().message);
    server = std::move(*opened);
    server->ready(true);
    std::filesystem::create_directories(root() + "/assets");
    write_file(root() + "/index.html", "<!doctype html><title>Driftwise</title>");
    write_file(root() + "/assets/index-BWqQ7d2x.js", "console.log('whole')");
    write_file(root() + "/assets/index-BWqQ7d2x.js.gz", "packed");
    write_file(root() + "/favicon.svg", "<svg/>");
    write_file(folder.path() + "/secret.txt", "not for you");
    auto tls = material();
    const bool secure = tls != nullptr;
    auto listening = web::HttpServer::open("127.0.0.1:0", std::move(tls));
    if (!listening) throw std::runtime_error(listening.error().message);
    http = std::move(*listening);
    http->serve(web::make_web_site({services.host, services.overview, server->in_process_channel(),
                                    root(), http->executor(), *access, secure, http->port()}));
  }
  void TearDown() override {
    http.reset();
    server.reset();
    access->authoriser().tell(nullptr);
  }

  std::string root() const { return folder.path() + "/web"; }
  std::string address() const { return http->address(); }

  // Of the cell file; and the door's certificate, none for a plain one.
  virtual AccessDescription description() { return {}; }
  virtual std::unique_ptr<tls::TlsMaterial> material() { return nullptr; }

  TemporaryFolder folder;
  std::unique_ptr<access::Access> access;
  LiveCell cell;
  Fakes fakes;  // set by the test's constructor
  std::unique_ptr<rpc::RpcServer> server;
  std::unique_ptr<web::HttpServer> http;
};

inline const std::string kGrpcWeb = "Content-Type: application/grpc-web+proto\r\n";

}  // namespace driftwise::tests
