#pragma once
// A raw HTTP/1.1 client for tests: it sends exactly the bytes it is given. Throws
// std::runtime_error when nothing comes within 20 s. Written against the RFCs, knows none of our
// headers.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/tls_client.h"

namespace driftwise::tests {

struct HttpReply {
  int status = 0;
  std::string head;  // with the status line
  std::string body;  // out of its chunks

  std::string header(const std::string& name) const;  // empty: not there
};

class HttpClient {
 public:
  explicit HttpClient(const std::string& address);                // "127.0.0.1:40200"
  HttpClient(const std::string& address, const TlsTrust& trust);  // https
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  void send(std::string_view bytes) const;
  HttpReply reply(bool to_head = false);
  std::string head();        // of a reply that comes in pieces
  std::string next_chunk();  // the next piece; empty: the last one
  std::string rest();        // all that comes until the other side closes
  bool closed();             // waits until the other side closes; false when bytes come instead
  void close();

  // With a Host header of this address.
  HttpReply get(const std::string& path, const std::string& headers = {});
  HttpReply post(const std::string& path, const std::string& headers, const std::string& body);

 private:
  bool receive();  // false: closed
  std::string until(std::string_view end);
  std::string exactly(std::size_t bytes);

  std::string address_, received_;
  int socket_ = -1;
  std::unique_ptr<TlsClient> tls_;
};

// gRPC-Web as its specification has it.
std::string framed(const std::string& message);
struct GrpcWebReply {
  std::vector<std::string> messages;
  std::string trailers;
  int status = -1;
};
GrpcWebReply unframed(const std::string& body);

}  // namespace driftwise::tests
