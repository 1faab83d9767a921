// Revocation lists as openssl(1) makes them.

#include "server/access/revoked_certificates.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <thread>

#include "server/access/authoriser.h"
#include "tests/support/process.h"

namespace driftwise::access {
namespace {

using testing::HasSubstr;

class RevokedCertificatesTest : public testing::Test {
 protected:
  RevokedCertificatesTest() {
    make_authority("authority");
    make_authority("other");
    for (const std::string name : {"ada", "eve"}) {
      openssl({"req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
               "-keyout", name + ".key", "-out", name + ".csr", "-subj", "/CN=" + name});
      openssl({"x509", "-req", "-in", name + ".csr", "-CA", "authority.pem", "-CAkey",
               "authority.key", "-CAcreateserial", "-days", "9", "-out", name + ".pem"});
    }
    write_list("authority");
  }
  void make_authority(const std::string& name) {
    openssl({"req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
             "-keyout", name + ".key", "-out", name + ".pem", "-days", "9", "-subj", "/CN=" + name,
             "-addext", "keyUsage = critical, keyCertSign, cRLSign"});
    tests::write_file(at(name + ".index"), "");
    tests::write_file(at(name + ".cnf"),
                      "[ca]\ndefault_ca = own\n[own]\ndatabase = " + at(name + ".index") +
                          "\ndefault_md = sha256\ndefault_crl_days = 1\ncertificate = " +
                          at(name + ".pem") + "\nprivate_key = " + at(name + ".key") + "\n");
  }
  void openssl(std::vector<std::string> words) const {
    words.insert(words.begin(), {"/usr/bin/env", "-C", folder.path(), "openssl"});
    const auto done = tests::run_process(words);
    if (done.code != 0) throw std::runtime_error(done.err);
  }
  void write_list(const std::string& authority) const {
    openssl({"ca", "-batch", "-config", authority + ".cnf", "-gencrl", "-out", "new.pem"});
    std::filesystem::rename(at("new.pem"), at("revoked.pem"));
  }
  std::string at(const std::string& name) const { return folder.path() + "/" + name; }
  std::string text(const std::string& name) const { return tests::read_file(at(name + ".pem")); }
  auto open() const { return RevokedCertificates::open(at("revoked.pem"), at("authority.pem")); }

  tests::TemporaryFolder folder;
};

TEST_F(RevokedCertificatesTest, AreKnownAsSoonAsTheListHasThem) {
  const auto list = open();
  ASSERT_TRUE(list) << list.error().message;
  EXPECT_FALSE((*list)->contains(text("ada")));
  openssl({"ca", "-batch", "-config", "authority.cnf", "-revoke", "ada.pem"});
  write_list("authority");
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!(*list)->contains(text("ada")) && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_TRUE((*list)->contains(text("ada")));
  EXPECT_FALSE((*list)->contains(text("eve")));
  EXPECT_FALSE((*list)->contains("")) << "no certificate was shown";
  EXPECT_TRUE((*list)->contains("-----BEGIN CERTIFICATE-----\nnonsense\n"));
  // What is no list changes nothing.
  tests::write_file(at("revoked.pem"), "nonsense");
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  EXPECT_TRUE((*list)->contains(text("ada")));
}

// A pipe that nobody writes to stands for a folder on a server that is gone.
TEST_F(RevokedCertificatesTest, AreToldFromMemoryWhileTheListDoesNotAnswer) {
  openssl({"ca", "-batch", "-config", "authority.cnf", "-revoke", "ada.pem"});
  write_list("authority");
  const auto list = open();
  ASSERT_TRUE(list) << list.error().message;
  std::filesystem::remove(at("revoked.pem"));
  ASSERT_EQ(::mkfifo(at("revoked.pem").c_str(), 0600), 0);
  int pipe = -1;  // opens as soon as somebody reads
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (pipe < 0 && std::chrono::steady_clock::now() < until) {
    pipe = ::open(at("revoked.pem").c_str(), O_WRONLY | O_NONBLOCK);
    if (pipe < 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_GE(pipe, 0) << "nobody looked at the list";
  EXPECT_TRUE((*list)->contains(text("ada")));
  EXPECT_FALSE((*list)->contains(text("eve")));
  ::close(pipe);
}

TEST_F(RevokedCertificatesTest, AreRefusedByTheAuthoriserInASentence) {
  openssl({"ca", "-batch", "-config", "authority.cnf", "-revoke", "ada.pem"});
  write_list("authority");
  const auto list = open();
  ASSERT_TRUE(list) << list.error().message;
  Authoriser authoriser({.revoked = list->get()});
  Evidence evidence{.door = Door::tls,
                    .from = "ipv4:10.0.0.2:1",
                    .certificate_name = "ada",
                    .certificate_uris = {"driftwise:role/admin"},
                    .certificate_pem = text("ada")};
  const auto refused = authoriser.identify(evidence);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unauthenticated);
  EXPECT_EQ(refused.error().reason, "CERTIFICATE_REVOKED");
  EXPECT_THAT(refused.error().message, HasSubstr("'ada' was revoked"));
  evidence.certificate_pem = text("eve");
  EXPECT_TRUE(authoriser.identify(evidence));
}

TEST_F(RevokedCertificatesTest, EndWhatWasBegunWithThem) {
  const Evidence evidence{.door = Door::tls,
                          .from = "ipv4:10.0.0.2:1",
                          .certificate_name = "ada",
                          .certificate_uris = {"driftwise:role/engineer"},
                          .certificate_pem = text("ada")};
  Identity session = *Authoriser({}).identify(evidence);
  session.proof = Proof::page_session;
  const auto before = open();
  ASSERT_TRUE(before) << before.error().message;
  EXPECT_TRUE(Authoriser({.revoked = before->get()}).in_force(session));
  openssl({"ca", "-batch", "-config", "authority.cnf", "-revoke", "ada.pem"});
  write_list("authority");
  const auto after = open();
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_FALSE(Authoriser({.revoked = after->get()}).in_force(session));
  const auto in_ten_days = [] { return std::time(nullptr) + 10 * 86'400; };
  EXPECT_FALSE(Authoriser({.utc_s = in_ten_days}).in_force(session)) << "it was made for nine days";
}

TEST_F(RevokedCertificatesTest, AreTakenOfTheirAuthorityAlone) {
  write_list("other");
  EXPECT_EQ(open().error().reason, "BAD_CERTIFICATE");
  EXPECT_THAT(open().error().message, HasSubstr("has not signed"));
  tests::write_file(at("revoked.pem"), "nonsense");
  EXPECT_THAT(open().error().message, HasSubstr("no revocation list"));
  std::filesystem::remove(at("revoked.pem"));
  EXPECT_EQ(open().error().reason, "NO_FILE");
  write_list("authority");
  EXPECT_TRUE(RevokedCertificates::check(at("revoked.pem"), at("authority.pem"), 1'700'000'000));
  EXPECT_EQ(RevokedCertificates::check(at("revoked.pem"), at("authority.pem"), 9'000'000'000)
                .error()
                .reason,
            "CERTIFICATE_EXPIRED")
      << "its next update is overdue";
}

}  // namespace
}  // namespace driftwise::access
