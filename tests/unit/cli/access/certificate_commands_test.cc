// driftwise cert: an authority is made once.

#include <filesystem>

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

namespace fs = std::filesystem;

class CertificateCommands : public CliTest {
 protected:
  void SetUp() override {
    if (run_process({"/usr/bin/env", "openssl", "version"}).code != 0)
      GTEST_SKIP() << "openssl is not installed (apt install openssl)";
    ASSERT_EQ(run({"cert", "init"}).exit, 0);
  }
  std::string path(const std::string& name) const { return folder.path() + "/tls/" + name; }
  std::map<std::string, std::string> files() const {
    std::map<std::string, std::string> texts;
    for (const auto& one : fs::directory_iterator(folder.path() + "/tls"))
      texts[one.path().filename().string()] = read_file(one.path().string());
    return texts;
  }
};

TEST_F(CertificateCommands, MakeAnotherServerCertificateByTheSameAuthority) {
  const auto before = files();
  ASSERT_EQ(run({"cert", "init"}).exit, 0);
  const auto after = files();
  EXPECT_EQ(after.at("authority.pem"), before.at("authority.pem"));
  EXPECT_EQ(after.at("revoked.pem"), before.at("revoked.pem"));
  EXPECT_NE(after.at("server.pem"), before.at("server.pem"));
}

TEST_F(CertificateCommands, KeepTheNamesOfTheCertificateBefore) {
  const auto names = [this] {
    return run_process({"/usr/bin/env", "openssl", "x509", "-in", path("server.pem"), "-noout",
                        "-ext", "subjectAltName"})
        .out;
  };
  ASSERT_EQ(run({"cert", "init", "--name", "cell7.lab.example", "--name", "10.0.0.7"}).exit, 0);
  const auto stated = names();
  EXPECT_THAT(stated, testing::AllOf(HasSubstr("DNS:cell7.lab.example"), HasSubstr("10.0.0.7")));
  ASSERT_EQ(run({"cert", "init"}).exit, 0);
  EXPECT_EQ(names(), stated);
  ASSERT_EQ(run({"cert", "init", "--name", "cell8"}).exit, 0);
  EXPECT_THAT(names(), testing::AllOf(HasSubstr("cell8"), testing::Not(HasSubstr("cell7"))));
}

// The key is kept off the measuring computer (docs/access.md): clients know the authority by its
// certificate, which a new one would lock out.
TEST_F(CertificateCommands, ReplaceNoAuthorityWhoseKeyIsKeptElsewhere) {
  for (const char* away : {"authority.key", "authority.pem"}) {
    fs::rename(path(away), folder.path() + "/elsewhere");
    const auto before = files();
    const auto refused = run({"cert", "init", "--json"});
    EXPECT_EQ(refused.exit, 3) << away;
    EXPECT_THAT(refused.err,
                testing::AllOf(HasSubstr("NO_FILE"), HasSubstr(path(away) + " is not there")));
    EXPECT_EQ(files(), before) << away;
    fs::rename(folder.path() + "/elsewhere", path(away));
  }
  EXPECT_EQ(run({"cert", "init"}).exit, 0) << "put back, it signs again";
}

}  // namespace
}  // namespace driftwise::tests
