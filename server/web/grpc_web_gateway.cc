#include "server/web/grpc_web_gateway.h"

#include <grpcpp/support/slice.h>

#include "server/access/authoriser.h"
#include "server/web/base64.h"
#include "server/web/forwarded_call.h"
#include "server/web/grpc_web_call.h"
#include "server/web/security_headers.h"

namespace driftwise::web {
namespace {

std::string frame_of(const grpc::ByteBuffer& message) {
  std::vector<grpc::Slice> slices;
  std::string out = data_frame_head(message.Length());
  out.reserve(out.size() + message.Length());
  if (message.Dump(&slices).ok())
    for (const auto& slice : slices)
      out.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  return out;
}

constexpr std::string_view kSessionOver = "the session has ended: log in again";

class CallBody final : public BodyStream {
 public:
  CallBody(std::shared_ptr<ForwardedCall> call, GrpcWebForm form, std::function<bool()> lasts)
      : call_(std::move(call)), form_(form), lasts_(std::move(lasts)) {}
  ~CallBody() override { call_->cancel(); }  // nothing to do when it is over

  Awaitable<Piece> next() override {
    const auto call = call_;
    auto waiting = call->next();
    const auto message = co_await std::move(waiting);
    Piece piece;
    if (message && lasts_ && !lasts_()) {
      call->cancel();
      piece.last = true;
      piece.bytes = trailers_frame(grpc::StatusCode::UNAUTHENTICATED, kSessionOver, {});
    } else {
      piece.last = !message;
      const grpc::Status& status = call->status();
      piece.bytes = message ? frame_of(*message)
                            : trailers_frame(status.error_code(), status.error_message(),
                                             status.error_details());
    }
    if (form_ == GrpcWebForm::text) piece.bytes = base64_encode(piece.bytes);
    co_return piece;
  }
  void abandon() override { call_->cancel(); }

 private:
  std::shared_ptr<ForwardedCall> call_;
  GrpcWebForm form_;
  std::function<bool()> lasts_;
};

HttpResponse answer_in(GrpcWebForm form) {
  HttpResponse response;
  response.headers = {{"Content-Type", std::string(content_type_of(form))},
                      {"Cache-Control", "no-store"}};
  add_security_headers(response);
  return response;
}

HttpResponse refused_call(GrpcWebForm form, const Error& error) {
  HttpResponse response = answer_in(form);
  const auto code = error.code == ErrorCode::unauthenticated ? grpc::StatusCode::UNAUTHENTICATED
                    : error.code == ErrorCode::resource_exhausted
                        ? grpc::StatusCode::RESOURCE_EXHAUSTED
                        : grpc::StatusCode::INVALID_ARGUMENT;
  response.body = trailers_frame(code, error.message, {});
  if (form == GrpcWebForm::text) response.body = base64_encode(response.body);
  return response;
}

}  // namespace

GrpcWebGateway::GrpcWebGateway(asio::any_io_executor executor,
                               const std::shared_ptr<grpc::Channel>& channel)
    : executor_(std::move(executor)), stub_(channel) {}

std::variant<HttpResponse, std::size_t> GrpcWebGateway::admit(const HttpRequest& head) {
  if (!is_method_path(head.path()))
    return plain_answer(404, "no call here: expected /driftwise.v1.Service/Method\n");
  if (head.method != "POST") {
    HttpResponse refused = plain_answer(405, "a call is made with POST\n");
    refused.headers.push_back({"Allow", "POST"});
    return refused;
  }
  const auto form = grpc_web_form(head.header("content-type"));
  if (!form)
    return plain_answer(415,
                        "Content-Type: expected application/grpc-web+proto or "
                        "application/grpc-web-text+proto\n");
  constexpr std::size_t kMost = kMaxMessageBytes + 5;
  return *form == GrpcWebForm::text ? (kMost + 2) / 3 * 4 : kMost;
}

HttpResponse GrpcWebGateway::refuse(const HttpRequest& request, const Error& error) {
  return refused_call(grpc_web_form(request.header("content-type")).value_or(GrpcWebForm::binary),
                      error);
}

HttpResponse GrpcWebGateway::open(HttpRequest request, Behalf behalf) {
  const GrpcWebForm form =
      grpc_web_form(request.header("content-type")).value_or(GrpcWebForm::binary);
  auto call = grpc_web_call(request);
  if (!call) return refused_call(form, call.error());
  const auto message = message_of_body(std::move(request.body), form);
  if (!message) return refused_call(form, message.error());
  if (!behalf.vouched.empty())
    call->metadata.push_back({access::Authoriser::kVouchedKey, std::move(behalf.vouched)});
  auto forwarded = std::make_shared<ForwardedCall>(executor_);
  forwarded->begin(stub_, *call, *message);
  HttpResponse response = answer_in(form);
  response.stream = std::make_shared<CallBody>(std::move(forwarded), form, std::move(behalf.lasts));
  return response;
}

}  // namespace driftwise::web
