// Files as openssl(1) makes them.

#include "server/access/certificate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "tests/support/process.h"

namespace driftwise::access {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int64_t kDay = 86'400;

std::int64_t now_utc_s() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

class CertificateTest : public testing::Test {
 protected:
  CertificateTest() { make("one"); }
  void make(const std::string& name) {
    const auto made = tests::run_process(
        {"/usr/bin/openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
         "-nodes", "-keyout", key(name), "-out", pem(name), "-days", "100", "-subj", "/CN=" + name,
         "-addext",
         "subjectAltName=DNS:cell7.lab.example,IP:10.0.0.7,IP:2001:db8::7,URI:driftwise:role/"
         "viewer"});
    if (made.code != 0) throw std::runtime_error(made.err);
    std::filesystem::permissions(
        key(name), std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  }
  std::string key(const std::string& name) const { return folder.path() + "/" + name + ".key"; }
  std::string pem(const std::string& name) const { return folder.path() + "/" + name + ".pem"; }
  tests::TemporaryFolder folder;
};

TEST_F(CertificateTest, TellsItsNamesAndItsEnd) {
  const auto facts = check_certificate(pem("one"), key("one"), now_utc_s());
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->subject, "one");
  EXPECT_EQ(facts->issuer, "one");
  EXPECT_THAT(facts->names, ElementsAre("cell7.lab.example", "10.0.0.7", "2001:db8::7"));
  EXPECT_THAT(facts->uris, ElementsAre("driftwise:role/viewer"));
  EXPECT_NEAR(static_cast<double>(facts->not_after_utc_s - now_utc_s()), 100.0 * kDay, 60.0);
}

// X.509 lets a name be a BMPString, two bytes a letter (RFC 5280, 4.1.2.4); Windows makes such.
TEST_F(CertificateTest, ReadsANameInWhateverEncodingItHas) {
  const auto made = tests::run_process(
      {"/bin/sh", "-c",
       "printf '[req]\\ndistinguished_name=dn\\nstring_mask=MASK:0x800\\nutf8=yes\\nprompt=no\\n"
       "[dn]\\nCN=M\303\274ller\\n' > \"$1/bmp.cnf\" && /usr/bin/openssl req -x509 -newkey ec "
       "-pkeyopt ec_paramgen_curve:P-256 -nodes -config \"$1/bmp.cnf\" -keyout \"$1/bmp.key\" "
       "-out \"$1/bmp.pem\" -days 100 && /usr/bin/openssl asn1parse -in \"$1/bmp.pem\"",
       "sh", folder.path()});
  ASSERT_EQ(made.code, 0) << made.err;
  ASSERT_THAT(made.out, HasSubstr("BMPSTRING")) << "openssl chose another encoding";
  const auto facts = read_certificate(pem("bmp"));
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->subject, "M\xC3\xBCller");
  EXPECT_EQ(facts->issuer, "M\xC3\xBCller");
}

TEST_F(CertificateTest, WarnsThirtyDaysAheadAndAfterTheEnd) {
  const auto facts = *read_certificate(pem("one"));
  const auto warning = [&](std::int64_t before_s) {
    return expiry_warning("server.pem", facts, facts.not_after_utc_s - before_s);
  };
  EXPECT_EQ(warning(30 * kDay + 1), "");
  EXPECT_THAT(warning(30 * kDay), HasSubstr("in 30 days"));
  EXPECT_THAT(warning(kDay), HasSubstr("in 1 days"));
  EXPECT_THAT(warning(0), HasSubstr("has ended"));
  EXPECT_EQ(check_certificate(pem("one"), key("one"), facts.not_after_utc_s).error().reason,
            "CERTIFICATE_EXPIRED");
  EXPECT_EQ(check_certificate(pem("one"), key("one"), facts.not_before_utc_s - 1).error().reason,
            "CERTIFICATE_EXPIRED");
}

TEST_F(CertificateTest, RefusesFilesThatCannotServe) {
  make("two");
  const auto reason = [](const std::string& certificate, const std::string& the_key) {
    const auto checked = check_certificate(certificate, the_key, now_utc_s());
    return checked ? "" : checked.error().reason;
  };
  EXPECT_EQ(reason(pem("one"), key("two")), "KEY_MISMATCH");
  EXPECT_EQ(reason(pem("none"), key("one")), "NO_FILE");
  EXPECT_EQ(reason(pem("one"), key("none")), "NO_FILE");
  EXPECT_EQ(reason(key("one"), key("one")), "BAD_CERTIFICATE");
  EXPECT_EQ(reason(pem("one"), folder.path()), "BAD_KEY") << "a folder";
  std::filesystem::permissions(pem("one"), std::filesystem::perms::owner_read);
  EXPECT_EQ(reason(pem("one"), pem("one")), "BAD_KEY");
  std::filesystem::permissions(key("one"), std::filesystem::perms::group_read,
                               std::filesystem::perm_options::add);
  EXPECT_EQ(reason(pem("one"), key("one")), "FILE_READABLE");
}

}  // namespace
}  // namespace driftwise::access
