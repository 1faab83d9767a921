// Who may ask on the text line: by certificate, by token, by address; over real sockets.

#include <gmock/gmock.h>

#include <algorithm>

#include "server/line/line_address.h"
#include "tests/unit/line/line_fixture.h"

namespace driftwise::line {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
using tests::TlsClient;

TEST_F(LineDoors, AnswerAControllerByItsCertificate) {
  ASSERT_TRUE(start(tls_door()));
  TlsClient controller(server_->address(),
                       certificates_.client("stage", "driftwise:role/controller"));
  EXPECT_THAT(controller.ask("TARGET x_mm=1"), StartsWith("OK q1_mm="));
}

TEST_F(LineDoors, RefuseAViewerInASentenceAndKeepTheConnection) {
  ASSERT_TRUE(start(tls_door()));
  TlsClient viewer(server_->address(), certificates_.client("vera", "driftwise:role/viewer"));
  for (int i = 0; i < 3; ++i)
    EXPECT_THAT(
        viewer.ask("TARGET x_mm=1"),
        testing::AllOf(StartsWith("ERR NEEDS_ROLE "), HasSubstr("vera"), HasSubstr("controller")));
}

TEST_F(LineDoors, RefuseACertificateWithoutARole) {
  ASSERT_TRUE(start(tls_door()));
  TlsClient unknown(server_->address(), certificates_.client("uwe", ""));
  EXPECT_THAT(unknown.line(), StartsWith("ERR NO_ROLE "));
  EXPECT_EQ(unknown.line(), "") << "closed";
}

TEST_F(LineDoors, WriteAFailedHandshakeIntoTheLogOnceForManyTries) {
  ASSERT_TRUE(start(tls_door()));
  const tests::TemporaryFolder elsewhere;
  const tests::TestCertificates others(elsewhere.path());
  auto stranger = others.client("stage", "driftwise:role/controller");
  stranger.authority = certificates_.path("authority.pem");
  for (int i = 0; i < 5; ++i) {
    try {
      EXPECT_EQ(TlsClient(server_->address(), stranger).line(), "");
    } catch (const std::runtime_error&) {  // refused while it connects
    }
  }
  // The door looks at the next client after those.
  TlsClient controller(server_->address(),
                       certificates_.client("stage", "driftwise:role/controller"));
  ASSERT_THAT(controller.ask("TARGET x_mm=1"), StartsWith("OK q1_mm="));
  const std::string told = log_.text();
  EXPECT_THAT(told, StartsWith("warning: text line " + server_->address() +
                               ": the TLS handshake with ipv4:127.0.0.1 failed: certificate verify "
                               "failed"));
  EXPECT_EQ(std::ranges::count(told, '\n'), 1) << told;
}

TEST_F(LineDoors, AskForATokenAndSayNothingBefore) {
  ASSERT_TRUE(start(tls_door()));
  const std::string good = token("stage", access::Role::controller);
  TlsClient client(server_->address(), certificates_.nobody());
  const std::string before = client.ask("TARGET x_mm=1");
  EXPECT_THAT(before, StartsWith("ERR NO_IDENTITY "));
  EXPECT_EQ(client.ask("MOVE x_mm=1"), before) << "what exists is not told";
  client.send("TOKEN " + good + "\nTARGET x_mm=1\r\n");  // sent ahead
  EXPECT_EQ(client.line(), "OK name=stage role=controller");
  EXPECT_THAT(client.line(), StartsWith("OK q1_mm="));
}

TEST_F(LineDoors, StopAnsweringATokenThatWasRevoked) {
  ASSERT_TRUE(start(tls_door()));
  const std::string text = token("stage", access::Role::controller);
  TlsClient client(server_->address(), certificates_.nobody());
  client.ask("TOKEN " + text);
  ASSERT_THAT(client.ask("TARGET x_mm=1"), StartsWith("OK q1_mm="));
  ASSERT_TRUE(access_->tokens().revoke(access_->tokens().list().front().id));
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  std::string answer;
  do answer = client.ask("TARGET x_mm=1");
  while (answer.starts_with("OK") && std::chrono::steady_clock::now() < end);
  EXPECT_THAT(answer, StartsWith("ERR NO_IDENTITY "));
}

TEST_F(LineDoors, StopAnsweringACertificateThatHasEnded) {
  ASSERT_TRUE(start(tls_door()));
  TlsClient controller(server_->address(),
                       certificates_.client("stage", "driftwise:role/controller"));
  ASSERT_THAT(controller.ask("TARGET x_mm=1"), StartsWith("OK q1_mm="));
  utc_s_ += 100LL * 365 * 86'400;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  std::string answer;
  do answer = controller.ask("TARGET x_mm=1");
  while (answer.starts_with("OK") && std::chrono::steady_clock::now() < end);
  EXPECT_THAT(answer, StartsWith("ERR NO_IDENTITY "));
}

TEST_F(LineDoors, GiveNoRightsToATokenThatWasRevokedBeforeTheyAreTaken) {
  LineRights rights(*access_, LineKind::tls, "ipv4:10.0.0.2:4711");
  const std::string text = token("stage", access::Role::controller);
  auto who = access_->authoriser().identify(rights.evidence_of(text));
  ASSERT_TRUE(who);
  ASSERT_TRUE(access_->tokens().revoke(who->credential));
  rights.take(std::move(*who));
  EXPECT_FALSE(rights.may_ask());
  EXPECT_FALSE(rights.known());
}

TEST_F(LineDoors, KeepTheRightsOfTheTokenOfTheStateFolder) {
  LineRights rights(*access_, LineKind::tls, "ipv4:10.0.0.2:4711");
  std::string text = tests::read_file(access_->token_file());
  text.pop_back();  // the line's end
  rights.take(*access_->authoriser().identify(rights.evidence_of(text)));
  utc_s_ += 100LL * 365 * 86'400;
  EXPECT_TRUE(rights.may_ask());
}

TEST_F(LineDoors, SlowWrongTokensAndCloseTheConnection) {
  ASSERT_TRUE(start(tls_door()));
  int tries = 0;
  std::string answer;
  while (!answer.starts_with("ERR TOO_MANY_TRIES") && tries < 40) {
    TlsClient client(server_->address(), certificates_.nobody());
    for (answer = client.ask("TOKEN dwt_wrong" + std::to_string(tries)); !answer.empty();
         answer = client.ask("TOKEN dwt_wrong" + std::to_string(tries))) {
      ++tries;
      if (!answer.starts_with("ERR BAD_TOKEN")) break;
    }
  }
  EXPECT_THAT(answer, StartsWith("ERR TOO_MANY_TRIES ")) << "after " << tries;
  EXPECT_LT(tries, 40);
}

TEST_F(LineDoors, AskForATokenOnPlainLoopbackWhereTheCellFileSaysSo) {
  ASSERT_TRUE(start({"127.0.0.1:0"}));
  tests::LineClient client(server_->address());
  EXPECT_THAT(client.ask("TARGET x_mm=1"), StartsWith("ERR NO_IDENTITY "));
  EXPECT_EQ(client.ask("TOKEN " + token("stage", access::Role::controller)),
            "OK name=stage role=controller");
  EXPECT_THAT(client.ask("TARGET x_mm=1"), StartsWith("OK q1_mm="));
}

TEST_F(LineDoors, StandPlainOnLoopbackOnly) {
  const auto refused = TargetLineServer::start(
      {context_.get_executor(), context_.get_executor(), board_, clock_, *access_},
      {"192.0.2.1:0"});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "LISTEN_NOT_LOOPBACK");
}

TEST_F(LineDoors, StandPlainOnANamedInterfaceForListedAddressesOnly) {
  const auto door = [](const char* address, const char* interface, std::vector<std::string> allow) {
    return LineDoor{address, LineKind::plain_network, nullptr, interface, std::move(allow)};
  };
  EXPECT_EQ(start(door("127.0.0.1:0", "lo", {})).error().reason, "MISSING_KEY");
  EXPECT_EQ(start(door("127.0.0.1:0", "lo", {"127.0.0.0/4"})).error().reason, "BAD_ADDRESS");
  EXPECT_EQ(start(door("192.0.2.1:0", "lo", {"127.0.0.1"})).error().reason, "NOT_ON_INTERFACE");
  EXPECT_EQ(start(door("127.0.0.1:0", "nowhere", {"127.0.0.1"})).error().reason, "NOT_ON_INTERFACE")
      << "another interface has it";
  const auto started = start(door("127.0.0.1:0", "lo", {"127.0.0.1"}));
  ASSERT_TRUE(started) << started.error().message;
  tests::LineClient listed(server_->address());
  EXPECT_THAT(listed.ask("TARGET x_mm=1"), StartsWith("OK q1_mm="));
  on_executor([this] { server_.reset(); });
  ASSERT_TRUE(start(door("127.0.0.1:0", "lo", {"127.0.0.2"})));
  tests::LineClient stranger(server_->address());
  EXPECT_EQ(stranger.line(), "") << "closed without a word";
  std::size_t turned_away = 0;
  on_executor([&] { turned_away = server_->turned_away(); });
  EXPECT_EQ(turned_away, 1U);
}

TEST(AddressList, HoldsAddressesAndNetworks) {
  const auto list = *AddressList::from({"192.168.7.10", "10.1.0.0/16", "fd00::/8"});
  const auto holds = [&](const char* text) {
    return list.holds(boost::asio::ip::make_address(text));
  };
  EXPECT_TRUE(holds("192.168.7.10"));
  EXPECT_FALSE(holds("192.168.7.11"));
  EXPECT_TRUE(holds("10.1.255.3"));
  EXPECT_FALSE(holds("10.2.0.1"));
  EXPECT_TRUE(holds("fd12::1"));
  EXPECT_FALSE(holds("::1"));
  EXPECT_TRUE(holds("::ffff:192.168.7.10")) << "the same controller on a door of both families";
}

}  // namespace
}  // namespace driftwise::line
