// A seeded grammar of hostile requests against the web door before any log-in, plain and behind
// TLS: nothing crashes, nothing of the cell is told, memory stays bounded. More of them:
// DRIFTWISE_HOSTILE_REQUESTS=100000.

#include <iostream>
#include <map>

#include "tests/support/hostile.h"
#include "tests/unit/web/web_fixture.h"

namespace driftwise::tests {
namespace {

constexpr std::size_t kMostGrowth = std::size_t{64} << 20;

class HostileRequests : public WebTest {
 protected:
  AccessDescription description() override {
    AccessDescription out;
    out.configured = true;
    out.loopback = LoopbackRule::token;
    return out;
  }
  // Names that only somebody who was let in may read: of the cell, a device, a channel, a token.
  void expect_nothing_told(const std::string& answer, const std::string& asked) const {
    for (const char* secret : {"\"small\"", "driftwise_info", "not for you", "q1_mm", "t07_degC",
                               "scrypt", "grpc-status: 0"})
      EXPECT_EQ(answer.find(secret), std::string::npos) << secret << " told to " << asked;
  }
  void expect_alive() const {
    HttpClient client(address());
    EXPECT_EQ(client.get("/healthz").status, 200);
  }
};

TEST_F(HostileRequests, TellNothingAndBreakNothing) {
  const int count = hostile_count(2000);
  Hostile hostile(20261122);
  const std::size_t before = resident_bytes();
  std::map<std::string, int> answers;
  for (int i = 0; i < count; ++i) {
    const std::string request = hostile.http();
    const std::string answer = answer_to(address(), request);
    expect_nothing_told(answer, request);
    ++answers[answer.starts_with("HTTP/1.1 ") ? answer.substr(9, 3) : "closed"];
    EXPECT_FALSE(answer.starts_with("HTTP/1.1 500")) << request;
  }
  expect_alive();
  EXPECT_LT(resident_bytes(), before + kMostGrowth);
  std::cout << "hostile requests, web door: " << count << ", answers";
  for (const auto& [status, times] : answers) std::cout << " " << status << ":" << times;
  std::cout << "; memory grew by " << (resident_bytes() - std::min(before, resident_bytes())) / 1024
            << " KiB\n";
  EXPECT_GE(answers.size(), 5U) << "the grammar reaches the parts of the door";
}

TEST_F(HostileRequests, HalfSentLeaveTheDoorOpen) {
  std::vector<std::unique_ptr<HttpClient>> slow;
  for (std::size_t i = 0; i < web::HttpServer::kMaxConnections + 20; ++i) {
    slow.push_back(std::make_unique<HttpClient>(address()));
    slow.back()->send(i % 2 ? "POST /session HTTP/1.1\r\nHost: loc" : "G");
  }
  expect_alive();
}

class HostileTls : public HostileRequests {
 protected:
  std::unique_ptr<tls::TlsMaterial> material() override {
    certificates.emplace(folder.path());
    return std::move(*tls::TlsMaterial::open(
        {certificates->path("server.pem"), certificates->path("server-key.pem"), ""},
        tls::ClientCertificate::ignored, "http/1.1"));
  }
  void expect_a_page() const {
    HttpClient client(address(), certificates->nobody());
    EXPECT_EQ(client.get("/healthz").status, 200);
  }
  std::optional<TestCertificates> certificates;
};

TEST_F(HostileTls, TellNothingAndBreakNothing) {
  const int count = hostile_count(2000);
  Hostile hostile(20261123);
  const std::size_t before = resident_bytes();
  std::map<std::string, int> answers;
  for (int i = 0; i < count; ++i) {
    const std::string bytes = i % 4 == 3 ? hostile.http() : hostile.tls();
    const std::string answer = answer_to(address(), bytes);
    expect_nothing_told(answer, bytes);
    ++answers[answer.empty()                       ? "closed"
              : answer.front() == '\x15'           ? "alert"
              : answer.front() == '\x16'           ? "handshake"
              : answer.starts_with("HTTP/1.1 400") ? "speak TLS"
                                                   : "other"];
  }
  expect_a_page();
  EXPECT_LT(resident_bytes(), before + kMostGrowth);
  std::cout << "hostile TLS, web door: " << count << ", answers";
  for (const auto& [kind, times] : answers) std::cout << " " << kind << ":" << times;
  std::cout << "\n";
  EXPECT_GE(answers.size(), 3U);
}

TEST_F(HostileTls, InsideTheTlsTooTellNothing) {
  const int count = hostile_count(2000) / 10;
  Hostile hostile(20261124);
  int closed = 0, answered = 0;
  for (int i = 0; i < count; ++i) {
    const std::string request = hostile.http();
    TlsClient client(address(), certificates->nobody());
    std::string answer;
    try {
      client.send(request);
      client.finish();
      for (std::string more = client.receive(); !more.empty(); more = client.receive())
        answer += more;
    } catch (const std::runtime_error&) {  // closed while it was sent
    }
    expect_nothing_told(answer, request);
    ++(answer.empty() ? closed : answered);
  }
  expect_a_page();
  std::cout << "hostile requests inside TLS: " << count << ", answered " << answered << ", closed "
            << closed << "\n";
  EXPECT_GT(answered, 0);
}

TEST_F(HostileTls, HalfHandshakesLeaveTheDoorOpen) {
  Hostile hostile(20261125);
  std::vector<std::unique_ptr<HttpClient>> slow;
  for (std::size_t i = 0; i < web::HttpServer::kMaxConnections + 20; ++i) {
    slow.push_back(std::make_unique<HttpClient>(address()));
    slow.back()->send("\x16\x03\x01");
  }
  expect_a_page();
}

}  // namespace
}  // namespace driftwise::tests
