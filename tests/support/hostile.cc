#include "tests/support/hostile.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace driftwise::tests {
namespace {

// What OpenSSL's client says first.
std::string client_hello() {
  SSL_CTX* context = SSL_CTX_new(TLS_client_method());
  SSL* ssl = SSL_new(context);
  BIO* in = BIO_new(BIO_s_mem());
  BIO* out = BIO_new(BIO_s_mem());
  SSL_set_bio(ssl, in, out);
  SSL_connect(ssl);  // it waits for an answer
  char bytes[4096];
  const int count = BIO_read(out, bytes, sizeof bytes);
  std::string hello(bytes, count > 0 ? static_cast<std::size_t>(count) : 0);
  SSL_free(ssl);
  SSL_CTX_free(context);
  return hello;
}

std::string big_endian(std::size_t value, int bytes) {
  std::string out;
  for (int i = bytes - 1; i >= 0; --i) out += static_cast<char>(value >> (8 * i) & 255U);
  return out;
}

}  // namespace

std::string Hostile::noise(std::size_t most) {
  std::string out(below(most + 1), '\0');
  for (char& c : out) c = static_cast<char>(random_());
  return out;
}

std::string Hostile::damaged(std::string bytes) {
  for (std::size_t times = 1 + below(4); times > 0 && !bytes.empty(); --times) {
    const std::size_t at = below(bytes.size()), length = below(bytes.size() - at) + 1;
    switch (below(5)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        bytes.erase(at, length);
        break;
      case 2:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 3:
        bytes.replace(at, length, noise(length));
        break;
      default:
        bytes.resize(at);
    }
    if (bytes.size() > 100'000) bytes.resize(100'000);
  }
  return bytes;
}

std::string Hostile::tls() {
  static const std::string hello = client_hello();
  switch (below(6)) {
    case 0:
      return hello;
    case 1:
    case 2:
      return damaged(hello);
    case 3: {  // a record of any type and version, its length true or not
      const std::string body = noise(400);
      const std::size_t length = once_in(2) ? body.size() : below(65536);
      return std::string(1, static_cast<char>(20 + below(6))) + std::string("\x03", 1) +
             static_cast<char>(below(5)) + big_endian(length, 2) + body;
    }
    case 4:
      return hello + damaged(hello) + noise(100);
    default:
      return noise(2000);
  }
}

std::string Hostile::token() {
  static const char* const kTokens[] = {"dwt_",
                                        "dwl_",
                                        "dwt_k3f9a2c1_",
                                        "dwt_k3f9a2c1_AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA",
                                        "",
                                        " ",
                                        "null",
                                        "../../tokens.json",
                                        "' OR 1=1 --",
                                        "\x1b[2J",
                                        "dwt_\xff\xfe",
                                        "Bearer"};
  std::string out = one_of(kTokens);
  if (once_in(3)) out = damaged(out + "x");
  if (once_in(10)) out += std::string(below(20'000), 'A');
  return out;
}

std::string Hostile::path() {
  static const char* const kPaths[] = {"/",
                                       "/now",
                                       "/session",
                                       "/metrics",
                                       "/healthz",
                                       "/log-in",
                                       "/../secret.txt",
                                       "/%2e%2e/%2e%2e/etc/passwd",
                                       "//",
                                       "/driftwise.v1.CellService/GetStatus",
                                       "/driftwise.v1.CellService/StopAll",
                                       "/driftwise.v1.AccessService/ListTokens",
                                       "/driftwise.v1.SecretService/GetSecret",
                                       "/driftwise.v1.",
                                       "/driftwise.v1.A/B/C",
                                       "http://evil.example/",
                                       "*",
                                       "",
                                       "/assets/%00",
                                       "/tokens.json",
                                       "/driftwised.token"};
  return once_in(4) ? damaged(std::string(one_of(kPaths)) + "x") : one_of(kPaths);
}

std::string Hostile::header() {
  static const char* const kNames[] = {"Content-Type",
                                       "Content-Length",
                                       "Transfer-Encoding",
                                       "Authorization",
                                       "Cookie",
                                       "Origin",
                                       "Host",
                                       "Expect",
                                       "Sec-Fetch-Site",
                                       "grpc-timeout",
                                       "driftwise-operator-bin",
                                       "driftwise-identity-bin",
                                       "driftwise-peer",
                                       "X",
                                       ""};
  static const char* const kValues[] = {"application/grpc-web+proto",
                                        "application/grpc-web-text",
                                        "application/json",
                                        "0",
                                        "-1",
                                        "18446744073709551616",
                                        "chunked",
                                        "gzip, chunked",
                                        "Bearer ",
                                        "same-origin",
                                        "cross-site",
                                        "null",
                                        "100-continue",
                                        "99999999H",
                                        "driftwise-8080=x; __Host-driftwise-8443=y",
                                        "%%%"};
  std::string value = one_of(kValues);
  if (once_in(4)) value += token();
  if (once_in(6)) value = damaged(value);
  if (once_in(40)) value += std::string(below(40'000), 'x');
  return std::string(one_of(kNames)) + (once_in(20) ? " " : ": ") + value +
         (once_in(20) ? "\n" : "\r\n");
}

std::string Hostile::frame() {
  const std::string body = noise(200);
  const std::size_t length =
      once_in(3) ? body.size() : static_cast<std::size_t>(random_() & 0xFFFFFFFFU);
  return std::string(1, static_cast<char>(once_in(2) ? 0 : below(256))) + big_endian(length, 4) +
         body;
}

std::string Hostile::http() {
  if (once_in(12)) return noise(3000);
  static const char* const kMethods[] = {"GET",     "POST",  "POST",    "POST", "DELETE", "HEAD",
                                         "OPTIONS", "TRACE", "CONNECT", "PRI",  "get",    "\x01"};
  static const char* const kVersions[] = {"HTTP/1.1", "HTTP/1.1", "HTTP/1.0", "HTTP/2.0",
                                          "HTTP/9",   "",         "HTP/1.1"};
  std::string out;
  for (std::size_t requests = 1 + below(3); requests > 0; --requests) {
    out += std::string(one_of(kMethods)) + " " + path() + " " + one_of(kVersions) + "\r\n";
    if (!once_in(5)) out += once_in(4) ? "Host: evil.example\r\n" : "Host: localhost\r\n";
    for (std::size_t headers = below(6); headers > 0; --headers) out += header();
    const std::string body = once_in(3)   ? frame()
                             : once_in(2) ? "{\"token\": \"" + token() + "\"}"
                                          : noise(300);
    if (!once_in(3)) out += "Content-Length: " + std::to_string(body.size()) + "\r\n";
    if (once_in(2)) out += "Content-Type: application/grpc-web+proto\r\n";
    if (!once_in(8)) out += "\r\n";
    out += body;
  }
  return once_in(3) ? damaged(out) : out;
}

std::string Hostile::line() {
  static const char* const kLines[] = {"TARGET x_mm=1",
                                       "TARGET",
                                       "TOKEN ",
                                       "TOKEN",
                                       "token x",
                                       "TARGET x_mm=1 x_mm=1",
                                       "TARGET x_mm=nan u=1",
                                       "MOVE x_mm=1",
                                       "HELP",
                                       "GET / HTTP/1.1",
                                       "",
                                       " ",
                                       "TARGET x_mm=1e999",
                                       "TARGET \xff=1",
                                       "\x1b[2J"};
  std::string out;
  for (std::size_t lines = 1 + below(4); lines > 0; --lines) {
    std::string one = one_of(kLines);
    if (once_in(3)) one = "TOKEN " + token();
    if (once_in(3)) one = damaged(one + "x");
    if (once_in(15)) one += noise(900);
    out += one + (once_in(8) ? "" : once_in(3) ? "\r\n" : "\n");
  }
  return once_in(10) ? noise(3000) : out;
}

std::string answer_to(const std::string& address, std::string_view bytes) {
  const auto colon = address.rfind(':');
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
  inet_pton(AF_INET, address.substr(0, colon).c_str(), &peer.sin_addr);
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (::connect(fd, reinterpret_cast<sockaddr*>(&peer), sizeof peer) != 0) {
    ::close(fd);
    throw std::runtime_error(address + ": cannot connect");
  }
  while (!bytes.empty()) {
    const auto count = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count <= 0) break;  // it has heard enough
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  ::shutdown(fd, SHUT_WR);
  std::string answer;
  for (;;) {
    pollfd wait_for{fd, POLLIN, 0};
    char more[65536];
    if (::poll(&wait_for, 1, 20'000) <= 0) {
      ::close(fd);
      throw std::runtime_error(address + ": not closed within 20 s; so far: " + answer);
    }
    const auto count = ::recv(fd, more, sizeof more, 0);
    if (count <= 0) break;
    answer.append(more, static_cast<std::size_t>(count));
  }
  ::close(fd);
  return answer;
}

std::size_t resident_bytes() {
#ifdef __SANITIZE_ADDRESS__
  return 0;  // its quarantine keeps 256 MB of freed memory: the figure says nothing
#endif
  std::ifstream statm("/proc/self/statm");
  std::size_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

int hostile_count(int usual) {
  const char* asked = std::getenv("DRIFTWISE_HOSTILE_REQUESTS");
  return asked == nullptr ? usual : std::max(1, std::atoi(asked));
}

}  // namespace driftwise::tests
