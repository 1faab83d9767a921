// A seeded grammar of hostile lines and TLS records against the text line before anybody has said
// who it is. More of them: DRIFTWISE_HOSTILE_REQUESTS=100000.

#include <gmock/gmock.h>

#include <iostream>
#include <map>

#include "tests/support/hostile.h"
#include "tests/unit/line/line_fixture.h"

namespace driftwise::line {
namespace {

using tests::Hostile;

TEST_F(LineDoors, TellHostileLinesNothing) {
  const int count = tests::hostile_count(2000);
  ASSERT_TRUE(start({"127.0.0.1:0"}));
  Hostile hostile(20261122);
  const std::size_t before = tests::resident_bytes();
  std::map<std::string, int> answers;
  for (int i = 0; i < count; ++i) {
    const std::string lines = hostile.line();
    const std::string answer = tests::answer_to(server_->address(), lines);
    EXPECT_EQ(("\n" + answer).find("\nOK "), std::string::npos) << lines;
    EXPECT_EQ(answer.find("q1"), std::string::npos) << lines;
    EXPECT_EQ(answer.find('\x1b'), std::string::npos) << "a terminal would obey it";
    const auto reason = answer.substr(0, answer.find(' ', 4));
    ++answers[answer.empty() ? "closed" : reason];
  }
  EXPECT_LT(tests::resident_bytes(), before + (std::size_t{64} << 20));
  std::cout << "hostile lines: " << count << ", first answers";
  for (const auto& [kind, times] : answers) std::cout << " " << kind << ":" << times;
  std::cout << "\n";
  tests::LineClient client(server_->address());
  EXPECT_THAT(client.ask("TARGET x_mm=1"), testing::StartsWith("ERR "));
}

TEST_F(LineDoors, SurviveHostileTlsRecords) {
  const int count = tests::hostile_count(2000);
  ASSERT_TRUE(start(tls_door()));
  Hostile hostile(20261123);
  int silent = 0;
  for (int i = 0; i < count; ++i)
    silent += tests::answer_to(server_->address(), hostile.tls()).empty() ? 1 : 0;
  std::cout << "hostile TLS, text line: " << count << ", closed without a word " << silent << "\n";
  tests::TlsClient controller(server_->address(),
                              certificates_.client("stage", "driftwise:role/controller"));
  EXPECT_THAT(controller.ask("TARGET x_mm=1"), testing::StartsWith("OK q1_mm="));
}

TEST_F(LineDoors, KeepAPlaceForAControllerWhileHalfHandshakesFillThem) {
  ASSERT_TRUE(start(tls_door()));
  std::vector<std::unique_ptr<tests::LineClient>> slow;
  for (std::size_t i = 0; i < TargetLineServer::kMaxClients + 10; ++i) {
    slow.push_back(std::make_unique<tests::LineClient>(server_->address()));
    slow.back()->send("\x16\x03\x01");
  }
  tests::TlsClient controller(server_->address(),
                              certificates_.client("stage", "driftwise:role/controller"));
  EXPECT_THAT(controller.ask("TARGET x_mm=1"), testing::StartsWith("OK q1_mm="));
}

}  // namespace
}  // namespace driftwise::line
