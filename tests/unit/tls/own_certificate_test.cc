// What a client can say of the certificate that it shows.

#include "server/tls/own_certificate.h"

#include <gmock/gmock.h>

#include <chrono>

#include "tests/support/process.h"
#include "tests/support/tls_client.h"

namespace driftwise::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class OwnCertificate : public testing::Test {
 protected:
  static std::int64_t in_days(int days) {
    return std::chrono::duration_cast<std::chrono::seconds>(
               std::chrono::system_clock::now().time_since_epoch())
               .count() +
           days * 86'400;
  }
  static std::string text(const std::string& path) { return read_file(path); }

  TemporaryFolder folder;
  TestCertificates certificates{folder.path()};
  TlsTrust ada = certificates.client("ada", "driftwise:role/operator");
  TlsTrust bob = certificates.client("bob", "driftwise:role/operator");
};

TEST_F(OwnCertificate, BelongsToItsKey) {
  EXPECT_TRUE(tls::check_pair(text(ada.certificate), text(ada.key)));
  const auto mixed = tls::check_pair(text(ada.certificate), text(bob.key));
  ASSERT_FALSE(mixed);
  EXPECT_EQ(mixed.error().reason, "KEY_MISMATCH");
  EXPECT_THAT(mixed.error().message, HasSubstr("does not belong to the certificate of 'ada'"));
  EXPECT_FALSE(tls::check_pair(text(ada.key), text(ada.certificate))) << "exchanged";
}

TEST_F(OwnCertificate, SaysWhyADaemonMayHaveRefusedIt) {
  const auto authority = text(certificates.path("authority.pem"));
  const auto doubts = [&](const std::string& of_whom, int days) {
    return tls::doubts_of(text(ada.certificate), of_whom, in_days(days));
  };
  EXPECT_EQ(doubts(authority, 0), "");
  EXPECT_THAT(doubts(authority, 400), AllOf(HasSubstr("the certificate of 'ada' has ended on "),
                                            HasSubstr("driftwise cert client")));
  EXPECT_THAT(doubts(authority, -400), HasSubstr("look at the computer's clock"));
  EXPECT_EQ(tls::doubts_of("", authority, in_days(0)), "") << "a token was shown";
}

}  // namespace
}  // namespace driftwise::tests
