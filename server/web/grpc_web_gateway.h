#pragma once
// Browsers speak gRPC-Web; the services speak gRPC. The gateway stands between them: it unpacks the
// request, makes the call over a channel inside the process and packs what comes back, message by
// message.
//
// Thread: the web thread (executor). The channel's server outlives all calls.

#include <grpcpp/channel.h>
#include <grpcpp/generic/generic_stub.h>

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>
#include <string>
#include <variant>

#include "server/web/grpc_web_frame.h"
#include "server/web/http_message.h"

namespace driftwise::web {

class GrpcWebGateway {
 public:
  static constexpr std::size_t kMaxMessageBytes = 33 * 1024 * 1024;  // as the gRPC door's

  GrpcWebGateway(asio::any_io_executor executor, const std::shared_ptr<grpc::Channel>& channel);

  // Is it a call, and may it come in? A refusal: 404 no such path, 405 not POST, 415 not gRPC-Web.
  static std::variant<HttpResponse, std::size_t> admit(const HttpRequest& head);

  // On whose behalf: vouched stands as metadata in the call (Authoriser::vouch); empty: nobody, and
  // the service decides. lasts: false ends a stream, as when the session is over; empty: it lasts.
  struct Behalf {
    std::string vouched;
    std::function<bool()> lasts;
  };
  // Always 200: what the call comes to stands in its trailers, also when the request was no frame.
  HttpResponse open(HttpRequest request, Behalf behalf);
  // The same form of answer without a call: nobody is logged in.
  static HttpResponse refuse(const HttpRequest& request, const Error& error);

 private:
  asio::any_io_executor executor_;
  grpc::GenericStub stub_;
};

}  // namespace driftwise::web
