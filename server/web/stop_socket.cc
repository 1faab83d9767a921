#include "server/web/stop_socket.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <utility>

#include "server/web/base64.h"
#include "server/web/security_headers.h"

namespace driftwise::web {
namespace {

// RFC 6455 section 4.2.2: proves that the server read the handshake; no secret.
std::string accept_of(std::string_view key) {
  const std::string text = std::string(key) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned int size = 0;
  if (EVP_Digest(text.data(), text.size(), bytes.data(), &size, EVP_sha1(), nullptr) != 1)
    throw std::runtime_error("OpenSSL made no SHA-1");
  return base64_encode({reinterpret_cast<const char*>(bytes.data()), size});
}

enum class Frame : unsigned char { go_on = 0x0, binary = 0x2, close = 0x8 };

// RFC 6455 section 5.2, from a server: without a mask.
std::string frame_of(Frame kind, bool last, std::string_view bytes) {
  std::string out;
  const auto put = [&out](std::size_t byte) { out += static_cast<char>(byte & 0xFFU); };
  put((last ? 0x80U : 0U) | static_cast<unsigned>(kind));
  const int size_bytes = bytes.size() < 126 ? 0 : bytes.size() < 0x10000 ? 2 : 8;
  put(size_bytes == 0 ? bytes.size() : size_bytes == 2 ? 126U : 127U);
  for (int i = size_bytes - 1; i >= 0; --i) put(bytes.size() >> (8 * i));
  return out.append(bytes);
}

constexpr std::string_view kNormalEnd("\x03\xE8", 2);  // 1000

// One message in as many frames as the call has pieces.
class SocketBody final : public BodyStream {
 public:
  explicit SocketBody(HttpResponse answer)
      : body_(std::move(answer.body)), inner_(std::move(answer.stream)) {}

  Awaitable<Piece> next() override {
    Piece piece{body_, true};
    if (inner_) {
      auto asking = inner_->next();
      piece = co_await std::move(asking);
    }
    piece.bytes = frame_of(std::exchange(next_, Frame::go_on), piece.last, piece.bytes);
    if (piece.last) piece.bytes += frame_of(Frame::close, true, kNormalEnd);
    co_return piece;
  }
  void abandon() override {
    if (inner_) inner_->abandon();
  }

 private:
  std::string body_;
  std::shared_ptr<BodyStream> inner_;
  Frame next_ = Frame::binary;
};

std::string operator_of(const HttpRequest& head) {
  constexpr std::string_view kName = "?operator=";
  std::string text = head.target.substr(head.path().size());
  if (!text.starts_with(kName)) return {};
  text.erase(0, kName.size());
  std::replace(text.begin(), text.end(), '-', '+');
  std::replace(text.begin(), text.end(), '_', '/');
  return text;
}

}  // namespace

bool asks_for_socket(const HttpRequest& head) {
  return lower(head.header("upgrade")).find("websocket") != std::string::npos;
}

std::optional<HttpResponse> refuse_socket(const HttpRequest& head) {
  if (head.path() != kStopPath)
    return plain_answer(404,
                        "no WebSocket here: Stop is the one at " + std::string(kStopPath) + "\n");
  const auto key = base64_decode(head.header("sec-websocket-key"));
  const bool upgrades = lower(head.header("connection")).find("upgrade") != std::string::npos;
  if (head.method != "GET" || !upgrades || !key || key->size() != 16)
    return plain_answer(400,
                        "no handshake of a WebSocket: expected GET, Connection: Upgrade and a "
                        "Sec-WebSocket-Key of 16 bytes in base64\n");
  if (head.header("sec-websocket-version") == "13") return std::nullopt;
  HttpResponse refused = plain_answer(426, "expected Sec-WebSocket-Version: 13\n");
  refused.headers.push_back({"Sec-WebSocket-Version", "13"});
  return refused;
}

HttpRequest call_of_socket(HttpRequest head) {
  std::string name = operator_of(head);
  std::erase_if(head.headers, [](const HttpHeader& one) {
    return one.name == "content-type" || one.name == "grpc-timeout" ||
           one.name.starts_with("driftwise-");
  });
  head.headers.push_back({"content-type", "application/grpc-web+proto"});
  if (!name.empty()) head.headers.push_back({"driftwise-operator-bin", std::move(name)});
  head.target = kStopPath;
  head.body.assign(5, '\0');  // one frame: an empty StopAllRequest
  return head;
}

HttpResponse socket_answer(HttpResponse answer, std::string_view key) {
  HttpResponse out;
  out.status = 101;
  out.headers = {{"Upgrade", "websocket"},
                 {"Connection", "Upgrade"},
                 {"Sec-WebSocket-Accept", accept_of(key)}};
  out.stream = std::make_shared<SocketBody>(std::move(answer));
  return out;
}

}  // namespace driftwise::web
