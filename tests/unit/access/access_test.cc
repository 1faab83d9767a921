// Access of a daemon, opened over files as openssl(1) makes them.

#include "server/access/access.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/process.h"

namespace driftwise::access {
namespace {

class AccessTest : public testing::Test {
 protected:
  AccessTest() {
    description.configured = true;
    description.listen = "127.0.0.1:0";
    description.certificate = at("server.pem");
    description.key = at("server.key");
    tests::write_file(at("index"), "");
    tests::write_file(at("ca.cnf"), "[ca]\ndefault_ca = own\n[own]\ndatabase = " + at("index") +
                                        "\nnew_certs_dir = " + folder.path() +
                                        "\nrand_serial = yes\ndefault_md = sha256\npolicy = any\n"
                                        "[any]\ncommonName = supplied\n");
    openssl({"req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
             "-keyout", at("server.key"), "-out", at("server.csr"), "-subj", "/CN=cell7"});
    std::filesystem::permissions(at("server.key"), std::filesystem::perms::owner_read);
  }
  // Instants as openssl takes them: "20240101000000Z".
  void certify(const std::string& from, const std::string& to) {
    tests::write_file(at("index"), "");
    openssl({"ca", "-batch", "-config", at("ca.cnf"), "-selfsign", "-keyfile", at("server.key"),
             "-in", at("server.csr"), "-startdate", from, "-enddate", to, "-notext", "-out",
             at("server.pem")});
  }
  void openssl(std::vector<std::string> words) const {
    words.insert(words.begin(), "/usr/bin/openssl");
    const auto done = tests::run_process(words);
    if (done.code != 0) throw std::runtime_error(done.err);
  }
  std::string at(const std::string& name) const { return folder.path() + "/" + name; }

  tests::TemporaryFolder folder;
  AccessDescription description;
};

TEST_F(AccessTest, OpensWithACertificateThatHasEnded) {
  certify("20240101000000Z", "20240301000000Z");
  const auto opened = Access::open(description, folder.path());
  ASSERT_TRUE(opened) << opened.error().reason << ": " << opened.error().message;
  EXPECT_TRUE(std::filesystem::exists((*opened)->token_file()));
}

TEST_F(AccessTest, OpensWithACertificateWhoseTimeHasNotComeByAClockThatIsBehind) {
  certify("20900101000000Z", "20910101000000Z");
  const auto opened = Access::open(description, folder.path());
  ASSERT_TRUE(opened) << opened.error().reason << ": " << opened.error().message;
}

TEST_F(AccessTest, DoesNotOpenWithFilesThatAreMissingOrDoNotBelongTogether) {
  EXPECT_EQ(Access::open(description, folder.path()).error().reason, "NO_FILE");
  certify("20240101000000Z", "20900101000000Z");
  openssl({"genpkey", "-algorithm", "EC", "-pkeyopt", "ec_paramgen_curve:P-256", "-out",
           at("other.key")});
  std::filesystem::permissions(at("other.key"), std::filesystem::perms::owner_read);
  description.key = at("other.key");
  EXPECT_EQ(Access::open(description, folder.path()).error().reason, "KEY_MISMATCH");
}

}  // namespace
}  // namespace driftwise::access
