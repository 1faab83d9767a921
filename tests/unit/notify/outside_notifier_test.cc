// Messages on the wire, to receivers that others wrote: Python's HTTP server, aiosmtpd, apprise.

#include "server/notify/outside_notifier.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "tests/unit/notify/receivers.h"

namespace driftwise::notify {
namespace {

using testing::HasSubstr;
using tests::HttpReceiver;
using tests::MailReceiver;

class OutsideNotifierTest : public testing::Test {
 protected:
  static Notice notice() {
    AlarmNews news;
    news.alarm.id = {7};
    news.alarm.level = AlarmLevel::failed;
    news.alarm.kind = "device.lost";
    news.alarm.subject = "laser-x";
    news.alarm.message = "laser-x is größer than it should be";
    news.since = {1'795'248'000'000'000'000};
    return {"cell-a", "", {1'795'248'010'000'000'000}, {news}, false};
  }
  static ReceiverDescription hook(const std::string& url) {
    ReceiverDescription out;
    out.name = "duty";
    out.webhook = url;
    return out;
  }
  static ReceiverDescription mail_to(const std::string& url, std::vector<std::string> to) {
    ReceiverDescription out;
    out.name = "mail";
    out.smtp = url;
    out.from = "cell@lab.example";
    out.to = std::move(to);
    return out;
  }
  std::string secret(const std::string& name, const std::string& text) const {
    const std::string path = folder.path() + "/" + name;
    tests::write_file(path, text);
    ::chmod(path.c_str(), 0600);
    return path;
  }
  tests::TemporaryFolder folder;
  OutsideNotifier notifier;
};

TEST_F(OutsideNotifierTest, AWebhookGetsTheMessageAndItsToken) {
  const HttpReceiver receiver(folder.path(), "hook", "ok");
  auto description = hook(receiver.url());
  description.token_file = secret("token", "s3cret\n");
  const auto said = notifier.tell(description, notice());
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(said->said, "HTTP 200: kept");
  const auto kept = receiver.kept();
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_EQ(kept[0].at("authorization"), "Bearer s3cret");
  EXPECT_EQ(kept[0].at("type"), "application/json");
  EXPECT_EQ(receiver.taken()[0].at("receiver"), "duty");
}

TEST_F(OutsideNotifierTest, ARefusalIsNoDelivery) {
  const HttpReceiver receiver(folder.path(), "hook", "500");
  const auto said = notifier.tell(hook(receiver.url()), notice());
  ASSERT_FALSE(said);
  EXPECT_EQ(said.error().reason, "NOT_DELIVERED");
  EXPECT_THAT(said.error().message, HasSubstr("HTTP 500: kept"));
  EXPECT_FALSE(notifier.tell(hook("http://127.0.0.1:1/"), notice()));
}

TEST_F(OutsideNotifierTest, ACallUnderWayEndsWithTheProgram) {
  const HttpReceiver receiver(folder.path(), "hook", "hang");
  std::thread end([this, &receiver] {
    for (int i = 0; i < 4000 && receiver.kept().empty(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    notifier.shut_down();
  });
  const auto before = std::chrono::steady_clock::now();
  const auto said = notifier.tell(hook(receiver.url()), notice());
  end.join();
  ASSERT_FALSE(said);
  EXPECT_EQ(said.error().reason, "SHUTTING_DOWN");
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(14));
}

TEST_F(OutsideNotifierTest, ASecretThatOthersMayReadIsRefused) {
  const std::string path = secret("token", "s3cret");
  ::chmod(path.c_str(), 0644);
  auto description = hook("http://127.0.0.1:1/");
  description.token_file = path;
  const auto said = notifier.tell(description, notice());
  ASSERT_FALSE(said);
  EXPECT_EQ(said.error().reason, "BAD_SECRET_FILE");
  EXPECT_THAT(said.error().message, HasSubstr("chmod 600"));
}

TEST_F(OutsideNotifierTest, AMailIsReadByAnotherParser) {
  const MailReceiver receiver(folder.path());
  const auto said =
      notifier.tell(mail_to(receiver.url(), {"ada@lab.example", "bob@lab.example"}), notice());
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(said->said, "250 2.0.0 kept");
  const auto kept = receiver.kept();
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_EQ(kept[0].at("from"), "cell@lab.example");
  EXPECT_EQ(kept[0].at("to"), (nlohmann::json{"ada@lab.example", "bob@lab.example"}));
  EXPECT_EQ(kept[0].at("subject"), "[cell-a] high: laser-x is größer than it should be");
  EXPECT_THAT(kept[0].at("text").get<std::string>(),
              HasSubstr("alarm 7, device.lost, since 2026-11-21T08:00:00Z"));
  EXPECT_TRUE(kept[0].at("defects").empty()) << kept[0];
}

TEST_F(OutsideNotifierTest, ARefusedRecipientKeepsAMailFromNobodyElse) {
  const MailReceiver receiver(folder.path());
  const auto said = notifier.tell(
      mail_to(receiver.url(), {"ada@lab.example", "gone@lab.example", "bob@lab.example"}),
      notice());
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(said->said,
            "250 2.0.0 kept; NOT DELIVERED to gone@lab.example: 550 5.1.1 no such user");
  ASSERT_EQ(said->refused.size(), 1U);
  EXPECT_EQ(said->refused[0].address, "gone@lab.example");
  EXPECT_FALSE(said->refused[0].for_now);
  ASSERT_EQ(receiver.kept().size(), 1U);
  EXPECT_EQ(receiver.kept()[0].at("to"), (nlohmann::json{"ada@lab.example", "bob@lab.example"}));
  const auto refused = notifier.tell(mail_to(receiver.url(), {"gone@lab.example"}), notice());
  ASSERT_FALSE(refused) << "nobody is left";
  EXPECT_EQ(refused.error().reason, "NOT_DELIVERED");
  EXPECT_THAT(refused.error().message, HasSubstr("550 5.1.1 no such user"));
  EXPECT_EQ(refused.error().code, ErrorCode::failed_precondition) << "no later try reaches anybody";
  EXPECT_EQ(receiver.kept().size(), 1U);
}

TEST_F(OutsideNotifierTest, ARecipientWhoIsRefusedForNowIsToldApartAndGetsTheSameMail) {
  const MailReceiver receiver(folder.path());
  const auto said =
      notifier.tell(mail_to(receiver.url(), {"ada@lab.example", "later@lab.example"}), notice());
  ASSERT_TRUE(said) << said.error().message;
  ASSERT_EQ(said->refused.size(), 1U);
  EXPECT_EQ(said->refused[0].address, "later@lab.example");
  EXPECT_EQ(said->refused[0].why, "450 4.2.0 greylisted, try again later");
  EXPECT_TRUE(said->refused[0].for_now);
  ASSERT_TRUE(notifier.tell(mail_to(receiver.url(), {"later@lab.example"}), notice()));
  const auto kept = receiver.kept();
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[1].at("to"), (nlohmann::json{"later@lab.example"}));
  EXPECT_EQ(kept[0].at("message_id"), kept[1].at("message_id"));
}

// STARTTLS with a certificate of the test's own, and a password.
TEST_F(OutsideNotifierTest, AMailWithAPasswordGoesThroughTls) {
  const std::string key = folder.path() + "/key.pem", certificate = folder.path() + "/cert.pem";
  const auto made =
      tests::run_process({"/usr/bin/openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes",
                          "-days", "2", "-subj", "/CN=localhost", "-addext",
                          "subjectAltName=DNS:localhost", "-keyout", key, "-out", certificate});
  ASSERT_EQ(made.code, 0) << made.err;
  const MailReceiver receiver(folder.path(), {certificate, key});
  auto mail = mail_to("smtp://127.0.0.1:" + receiver.port(), {"ada@lab.example"});
  mail.user = "robot";
  mail.password_file = secret("password", "secret word\n");
  // On loopback a mail goes as it is, and this server wants more.
  EXPECT_THAT(notifier.tell(mail, notice()).error().message, HasSubstr("STARTTLS"));
  mail.ca_file = certificate;
  // The name in the certificate is another one than the address.
  EXPECT_FALSE(notifier.tell(mail, notice()));
  mail.smtp = "smtp://localhost:" + receiver.port();
  const auto said = notifier.tell(mail, notice());
  ASSERT_TRUE(said) << said.error().message;
  ASSERT_EQ(receiver.kept().size(), 1U);
  EXPECT_EQ(receiver.kept()[0].at("user"), "robot");
  EXPECT_EQ(receiver.kept()[0].at("tls"), true);
}

TEST_F(OutsideNotifierTest, AppriseDelivers) {
  const HttpReceiver receiver(folder.path(), "apprise", "ok");
  ReceiverDescription description;
  description.name = "apprise";
  description.command = {"apprise", "-t",     "{title}",
                         "-b",      "{text}", "json://127.0.0.1:" + receiver.port() + "/"};
  const auto said = notifier.tell(description, notice());
  ASSERT_TRUE(said) << said.error().message;
  ASSERT_EQ(receiver.taken().size(), 1U);
  EXPECT_EQ(receiver.taken()[0].at("title"), "[cell-a] high: laser-x is größer than it should be");
  EXPECT_THAT(receiver.taken()[0].at("message").get<std::string>(), HasSubstr("alarm 7"));
}

}  // namespace
}  // namespace driftwise::notify
