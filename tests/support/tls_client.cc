#include "tests/support/tls_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <stdexcept>
#include <vector>

#include "tests/support/process.h"

namespace driftwise::tests {
namespace {

constexpr int kLimit_s = 20;

[[noreturn]] void give_up(const std::string& address, const std::string& what) {
  throw std::runtime_error(address + ": " + what);
}

int connect_to(const std::string& address) {
  const auto colon = address.rfind(':');
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
  inet_pton(AF_INET, address.substr(0, colon).c_str(), &peer.sin_addr);
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const timeval limit{kLimit_s, 0};
  ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  if (::connect(fd, reinterpret_cast<sockaddr*>(&peer), sizeof peer) != 0) {
    ::close(fd);
    give_up(address, "cannot connect");
  }
  return fd;
}

void run_openssl(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "/usr/bin/openssl");
  const auto done = run_process(arguments);
  if (done.code != 0) throw std::runtime_error("openssl: " + done.err);
}

}  // namespace

struct TlsClient::Connection {
  std::string address;
  int fd = -1;
  SSL_CTX* context = nullptr;
  SSL* ssl = nullptr;
  ~Connection() {
    SSL_free(ssl);
    SSL_CTX_free(context);
    if (fd >= 0) ::close(fd);
  }
};

TlsClient::TlsClient(const std::string& address, const TlsTrust& trust)
    : connection_(std::make_unique<Connection>()) {
  std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes without MSG_NOSIGNAL
  auto& c = *connection_;
  c.address = address;
  c.context = SSL_CTX_new(TLS_client_method());
  if (!trust.authority.empty()) {
    SSL_CTX_load_verify_locations(c.context, trust.authority.c_str(), nullptr);
    SSL_CTX_set_verify(c.context, SSL_VERIFY_PEER, nullptr);
  }
  if (!trust.certificate.empty()) {
    SSL_CTX_use_certificate_chain_file(c.context, trust.certificate.c_str());
    SSL_CTX_use_PrivateKey_file(c.context, trust.key.c_str(), SSL_FILETYPE_PEM);
  }
  c.fd = connect_to(address);
  c.ssl = SSL_new(c.context);
  SSL_set_fd(c.ssl, c.fd);
  if (trust.name.empty())
    X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(c.ssl),
                                  address.substr(0, address.rfind(':')).c_str());
  else
    SSL_set1_host(c.ssl, trust.name.c_str());
  if (SSL_connect(c.ssl) != 1) give_up(address, "no TLS was agreed");
}

TlsClient::~TlsClient() = default;

void TlsClient::send(std::string_view bytes) const {
  if (bytes.empty()) return;
  if (SSL_write(connection_->ssl, bytes.data(), static_cast<int>(bytes.size())) <= 0)
    give_up(connection_->address, "closed while sending");
}

void TlsClient::finish() const { SSL_shutdown(connection_->ssl); }

std::string TlsClient::receive() const {
  char bytes[16384];
  const int count = SSL_read(connection_->ssl, bytes, sizeof bytes);
  if (count > 0) return {bytes, static_cast<std::size_t>(count)};
  if (errno == EAGAIN && SSL_get_error(connection_->ssl, count) == SSL_ERROR_WANT_READ)
    give_up(connection_->address, "nothing came");
  return {};
}

std::string TlsClient::line() {
  std::size_t end;
  while ((end = received_.find('\n')) == std::string::npos) {
    const std::string more = receive();
    if (more.empty()) return {};
    received_ += more;
  }
  std::string out = received_.substr(0, end);
  received_.erase(0, end + 1);
  return out;
}

std::string TlsClient::ask(const std::string& request) {
  send(request + "\n");
  return line();
}

std::string TlsClient::subject_of_server() const {
  X509* certificate = SSL_get1_peer_certificate(connection_->ssl);
  char name[256] = "";
  X509_NAME_get_text_by_NID(X509_get_subject_name(certificate), NID_commonName, name, sizeof name);
  X509_free(certificate);
  return name;
}

std::string TlsClient::serial_of_server() const {
  X509* certificate = SSL_get1_peer_certificate(connection_->ssl);
  BIGNUM* number = ASN1_INTEGER_to_BN(X509_get_serialNumber(certificate), nullptr);
  char* text = BN_bn2dec(number);
  std::string out = text;
  OPENSSL_free(text);
  BN_free(number);
  X509_free(certificate);
  return out;
}

TestCertificates::TestCertificates(std::string folder) : folder_(std::move(folder)) {
  run_openssl({"req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
               "-days", "30", "-subj", "/CN=test authority", "-keyout", path("authority-key.pem"),
               "-out", path("authority.pem")});
  renew_server();
}

void TestCertificates::renew_server() const {
  sign("server", "daemon",
       "IP:127.0.0.1,IP:127.0.0.2,IP:127.0.0.3,DNS:localhost,DNS:cell.lab.example", "serverAuth");
}

TlsTrust TestCertificates::client(const std::string& name, const std::string& uri) const {
  sign(name, name, uri.empty() ? "DNS:" + name : "URI:" + uri, "clientAuth");
  return {path("authority.pem"), path(name + ".pem"), path(name + "-key.pem")};
}

void TestCertificates::sign(const std::string& stem, const std::string& name,
                            const std::string& alternative, const std::string& usage) const {
  const std::string extensions = path(stem + ".ext"), request = path(stem + ".csr");
  write_file(extensions, "subjectAltName=" + alternative + "\nextendedKeyUsage=" + usage + "\n");
  run_openssl({"req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj",
               "/CN=" + name, "-keyout", path(stem + "-key.pem"), "-out", request});
  run_openssl({"x509", "-req", "-in", request, "-CA", path("authority.pem"), "-CAkey",
               path("authority-key.pem"), "-CAcreateserial", "-days", "20", "-extfile", extensions,
               "-out", path(stem + ".pem")});
}

}  // namespace driftwise::tests
