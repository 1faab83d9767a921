#include "tests/support/http_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <utility>

namespace driftwise::tests {
namespace {

constexpr int kLimitMs = 20'000;

std::string lower_case(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 32);
  return text;
}

std::size_t big_endian(std::string_view four) {
  std::size_t out = 0;
  for (const char c : four) out = out << 8 | static_cast<unsigned char>(c);
  return out;
}

}  // namespace

std::string HttpReply::header(const std::string& name) const {
  const std::string wanted = "\r\n" + lower_case(name) + ": ";
  const std::size_t at = lower_case(head).find(wanted);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + wanted.size();
  return head.substr(begin, head.find("\r\n", begin) - begin);
}

HttpClient::HttpClient(const std::string& address) : address_(address) {
  const auto colon = address.rfind(':');
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
  inet_pton(AF_INET, address.substr(0, colon).c_str(), &peer.sin_addr);
  socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connect(socket_, reinterpret_cast<sockaddr*>(&peer), sizeof peer) != 0) {
    close();
    throw std::runtime_error("cannot connect to " + address);
  }
}

HttpClient::HttpClient(const std::string& address, const TlsTrust& trust)
    : address_(address), tls_(std::make_unique<TlsClient>(address, trust)) {}

HttpClient::~HttpClient() { close(); }

void HttpClient::close() {
  tls_.reset();
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

void HttpClient::send(std::string_view bytes) const {
  if (tls_) return tls_->send(bytes);
  while (!bytes.empty()) {
    const auto count = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count < 0) throw std::runtime_error(address_ + ": closed while sending");
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

bool HttpClient::receive() {
  if (tls_) {
    const std::string more = tls_->receive();
    received_ += more;
    return !more.empty();
  }
  pollfd wait_for{socket_, POLLIN, 0};
  if (poll(&wait_for, 1, kLimitMs) <= 0)
    throw std::runtime_error(address_ + ": nothing came; so far: " + received_);
  char bytes[65536];
  const auto count = recv(socket_, bytes, sizeof bytes, 0);
  if (count > 0) received_.append(bytes, static_cast<std::size_t>(count));
  return count > 0;
}

std::string HttpClient::until(std::string_view end) {
  std::size_t at;
  while ((at = received_.find(end)) == std::string::npos)
    if (!receive()) throw std::runtime_error(address_ + ": closed after: " + received_);
  std::string out = received_.substr(0, at + end.size());
  received_.erase(0, at + end.size());
  return out;
}

std::string HttpClient::exactly(std::size_t bytes) {
  while (received_.size() < bytes)
    if (!receive()) throw std::runtime_error(address_ + ": closed within a body");
  std::string out = received_.substr(0, bytes);
  received_.erase(0, bytes);
  return out;
}

std::string HttpClient::head() { return until("\r\n\r\n"); }

std::string HttpClient::next_chunk() {
  const std::size_t bytes = std::stoul(until("\r\n"), nullptr, 16);
  std::string out = exactly(bytes);
  if (exactly(2) != "\r\n") throw std::runtime_error(address_ + ": a chunk without its end");
  return out;
}

std::string HttpClient::rest() {
  while (receive()) {
  }
  return std::exchange(received_, {});
}

HttpReply HttpClient::reply(bool to_head) {
  HttpReply out;
  out.head = head();
  out.status = std::stoi(out.head.substr(out.head.find(' ')));
  if (to_head || out.status == 304) return out;
  if (out.header("transfer-encoding") == "chunked") {
    for (std::string chunk = next_chunk(); !chunk.empty(); chunk = next_chunk()) out.body += chunk;
  } else if (const auto length = out.header("content-length"); !length.empty()) {
    out.body = exactly(std::stoul(length));
  }
  return out;
}

bool HttpClient::closed() {
  if (!received_.empty()) return false;
  return !receive();
}

HttpReply HttpClient::get(const std::string& path, const std::string& headers) {
  send("GET " + path + " HTTP/1.1\r\nHost: " + address_ + "\r\n" + headers + "\r\n");
  return reply();
}

HttpReply HttpClient::post(const std::string& path, const std::string& headers,
                           const std::string& body) {
  send("POST " + path + " HTTP/1.1\r\nHost: " + address_ + "\r\n" + headers +
       "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  return reply();
}

std::string framed(const std::string& message) {
  std::string out(1, '\0');
  for (const int shift : {24, 16, 8, 0}) out += static_cast<char>(message.size() >> shift & 255U);
  return out + message;
}

GrpcWebReply unframed(const std::string& body) {
  GrpcWebReply out;
  for (std::size_t at = 0; at < body.size();) {
    if (body.size() - at < 5) throw std::runtime_error("a frame cut off");
    const bool trailers = (static_cast<unsigned char>(body[at]) & 0x80U) != 0;
    const std::size_t bytes = big_endian(std::string_view(body).substr(at + 1, 4));
    if (body.size() - at - 5 < bytes) throw std::runtime_error("a frame cut off");
    (trailers ? out.trailers : out.messages.emplace_back()) = body.substr(at + 5, bytes);
    at += 5 + bytes;
  }
  if (const auto at = out.trailers.find("grpc-status: "); at != std::string::npos)
    out.status = std::stoi(out.trailers.substr(at + 13));
  return out;
}

}  // namespace driftwise::tests
