// Certificates from files, against the openssl library's own client.

#include "server/tls/tls_material.h"

#include <gmock/gmock.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <filesystem>
#include <thread>

#include "server/tls/peer_certificate.h"
#include "tests/support/process.h"
#include "tests/support/tls_client.h"

namespace driftwise::tests {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using testing::HasSubstr;

class Material : public testing::Test {
 protected:
  tls::TlsFiles files() const {
    return {certificates.path("server.pem"), certificates.path("server-key.pem"),
            certificates.path("authority.pem")};
  }
  // One handshake of a client with a server that takes its context from the material; runs
  // `inspect` on the server's side.
  template <class Inspect>
  void shake_hands(tls::TlsMaterial& material, const TlsTrust& trust, Inspect inspect,
                   std::string* serial = nullptr) {
    asio::io_context context;
    tcp::acceptor acceptor(context, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
    const std::string address = "127.0.0.1:" + std::to_string(acceptor.local_endpoint().port());
    std::thread client([&] {
      try {
        const TlsClient one(address, trust);
        if (serial) *serial = one.serial_of_server();
      } catch (const std::runtime_error&) {  // refused: the server's side says why
      }
    });
    const auto tls = material.context();
    asio::ssl::stream<tcp::socket> stream(acceptor.accept(), *tls);
    boost::system::error_code failed;
    stream.handshake(asio::ssl::stream_base::server, failed);
    inspect(stream.native_handle(), failed);
    stream.next_layer().close();
    client.join();
  }

  const TemporaryFolder folder;
  const TestCertificates certificates{folder.path()};
};

TEST_F(Material, ServesARenewedCertificateToTheNextConnectionWithoutARestart) {
  auto material = *tls::TlsMaterial::open(files(), tls::ClientCertificate::accepted);
  std::string before, after;
  const auto agreed = [](SSL*, const auto& failed) { EXPECT_FALSE(failed) << failed.message(); };
  shake_hands(*material, certificates.nobody(), agreed, &before);
  certificates.renew_server();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  do shake_hands(*material, certificates.nobody(), agreed, &after);
  while (after == before && std::chrono::steady_clock::now() < end);
  EXPECT_NE(after, before);
  EXPECT_FALSE(material->problem());
}

TEST_F(Material, KeepsTheLastGoodSetWhileTheFilesDoNotFitTogether) {
  auto material = *tls::TlsMaterial::open(files(), tls::ClientCertificate::accepted);
  std::filesystem::copy_file(certificates.path("authority-key.pem"),
                             certificates.path("server-key.pem"),
                             std::filesystem::copy_options::overwrite_existing);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!material->problem() && std::chrono::steady_clock::now() < end)
    shake_hands(*material, certificates.nobody(),
                [](SSL*, const auto& failed) { EXPECT_FALSE(failed) << failed.message(); });
  ASSERT_TRUE(material->problem());
  EXPECT_THAT(*material->problem(), HasSubstr("does not belong to"));
}

TEST_F(Material, ReadsNameAndRoleOfAClientThatTheAuthoritySigned) {
  auto material = *tls::TlsMaterial::open(files(), tls::ClientCertificate::accepted);
  shake_hands(*material, certificates.client("ada", "driftwise:role/operator"),
              [](SSL* ssl, const auto& failed) {
                ASSERT_FALSE(failed) << failed.message();
                const auto peer = tls::peer_certificate(ssl);
                ASSERT_TRUE(peer);
                EXPECT_EQ(peer->name, "ada");
                EXPECT_THAT(peer->uris, testing::ElementsAre("driftwise:role/operator"));
              });
  shake_hands(*material, certificates.nobody(), [](SSL* ssl, const auto& failed) {
    ASSERT_FALSE(failed) << failed.message();
    EXPECT_FALSE(tls::peer_certificate(ssl)) << "it showed none";
  });
}

TEST_F(Material, EndsTheHandshakeOfAClientOfAnotherAuthority) {
  auto material = *tls::TlsMaterial::open(files(), tls::ClientCertificate::accepted);
  const TemporaryFolder elsewhere;
  const TestCertificates others(elsewhere.path());
  auto stranger = others.client("eve", "driftwise:role/admin");
  stranger.authority = certificates.path("authority.pem");
  shake_hands(*material, stranger,
              [](SSL*, const auto& failed) { EXPECT_TRUE(failed) << "eve came in"; });
}

TEST_F(Material, NamesTheFileThatIsMissingOrWrong) {
  const auto message_with = [&](tls::TlsFiles wanted) {
    const auto opened = tls::TlsMaterial::open(std::move(wanted), tls::ClientCertificate::accepted);
    return opened ? std::string("it opened") : opened.error().message;
  };
  auto missing = files();
  missing.certificate = folder.path() + "/nowhere.pem";
  EXPECT_THAT(message_with(missing), HasSubstr("nowhere.pem"));
  auto other_key = files();
  other_key.key = certificates.path("authority-key.pem");
  EXPECT_THAT(message_with(other_key), HasSubstr("does not belong to"));
  auto no_pem = files();
  write_file(folder.path() + "/text.pem", "not a certificate");
  no_pem.authority = folder.path() + "/text.pem";
  EXPECT_THAT(message_with(no_pem), HasSubstr("text.pem"));
}

}  // namespace
}  // namespace driftwise::tests
