#pragma once
// A blocking TLS client for tests, and certificates made by the openssl program: an authority, a
// server's for loopback, clients' with a role. Throws std::runtime_error when nothing comes within
// 20 s, or the other side is not trusted.

#include <memory>
#include <string>
#include <string_view>

namespace driftwise::tests {

struct TlsTrust {
  std::string authority;         // PEM file; empty: nobody is checked
  std::string certificate, key;  // what the client shows; empty: nothing
  std::string name = {};         // of the server, in place of its address
};

class TlsClient {
 public:
  TlsClient(const std::string& address, const TlsTrust& trust);
  ~TlsClient();
  TlsClient(const TlsClient&) = delete;
  TlsClient& operator=(const TlsClient&) = delete;

  void send(std::string_view bytes) const;
  void finish() const;                          // nothing more follows
  std::string receive() const;                  // some bytes; empty: closed
  std::string line();                           // without its end; empty: closed
  std::string ask(const std::string& request);  // with a line end, and the line that answers
  std::string subject_of_server() const;        // its common name
  std::string serial_of_server() const;         // as a decimal number

 private:
  struct Connection;
  std::unique_ptr<Connection> connection_;
  std::string received_;
};

// authority.pem, server.pem, server-key.pem, and for each role ROLE.pem, ROLE-key.pem in a folder.
class TestCertificates {
 public:
  explicit TestCertificates(std::string folder);  // makes authority and server
  // A server certificate anew, with another serial number, under the same names.
  void renew_server() const;
  TlsTrust client(const std::string& name,
                  const std::string& uri) const;  // "driftwise:role/viewer"
  TlsTrust nobody() const { return {path("authority.pem"), "", ""}; }
  std::string path(const std::string& file) const { return folder_ + "/" + file; }

 private:
  void sign(const std::string& stem, const std::string& name, const std::string& alternative,
            const std::string& usage) const;
  std::string folder_;
};

}  // namespace driftwise::tests
