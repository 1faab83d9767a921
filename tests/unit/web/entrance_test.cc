// The log-in of the page over TLS and over plain loopback, as a browser and as a script meet it.

#include <nlohmann/json.hpp>
#include <thread>

#include "driftwise/v1/cell_service.pb.h"
#include "tests/unit/web/web_fixture.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using Json = nlohmann::json;

constexpr int kUnauthenticated = 16, kPermissionDenied = 7;
const std::string kStatus = "/driftwise.v1.CellService/GetStatus";
const std::string kHome = "/driftwise.v1.CellService/Home";
const std::string kJson = "Content-Type: application/json\r\n";

// Of a Set-Cookie header: "name=value".
std::string cookie_of(const HttpReply& reply) {
  const auto header = reply.header("set-cookie");
  return header.substr(0, header.find(';'));
}

class Entering : public WebTest {
 protected:
  AccessDescription description() override {
    AccessDescription out;
    out.configured = true;
    out.loopback = LoopbackRule::token;
    return out;
  }
  std::string token(const std::string& name, access::Role role) {
    return access->tokens().create(name, role, "test", 0, std::nullopt)->text;
  }
  // As a page sends it: the browser says where it comes from.
  std::string from_page(const std::string& cookie) const {
    return "Origin: " + http->origin() + "\r\n" +
           (cookie.empty() ? "" : "Cookie: " + cookie + "\r\n");
  }
  HttpReply log_in(HttpClient& client, const std::string& what, const std::string& text) const {
    return client.post("/session", kJson + from_page(""), Json{{what, text}}.dump());
  }
  int call(HttpClient& client, const std::string& path, const std::string& headers) const {
    return unframed(client.post(path, kGrpcWeb + headers, framed("")).body).status;
  }
};

TEST_F(Entering, GivesThePageToEverybodyAndTheCellToNobody) {
  HttpClient client(address());
  EXPECT_EQ(client.get("/now").status, 200);
  EXPECT_EQ(client.get("/healthz").status, 200);
  EXPECT_EQ(client.get("/metrics").status, 401);
  EXPECT_EQ(call(client, kStatus, from_page("")), kUnauthenticated);
  const auto who = Json::parse(client.get("/session").body);
  EXPECT_EQ(who["state"], "out");
  EXPECT_THAT(who["message"], HasSubstr("driftwise open"));
}

TEST_F(Entering, LogsInByATokenAndKnowsTheNameAndRole) {
  HttpClient client(address());
  const auto reply = log_in(client, "token", token("vera", access::Role::viewer));
  ASSERT_EQ(reply.status, 200) << reply.body;
  EXPECT_THAT(reply.header("set-cookie"),
              testing::AllOf(HasSubstr("; HttpOnly"), HasSubstr("; SameSite=Strict"),
                             HasSubstr("; Path=/"), Not(HasSubstr("Secure"))));
  EXPECT_THAT(reply.body, Not(HasSubstr("dwt_")));
  const auto cookie = cookie_of(reply);
  const auto who = Json::parse(client.get("/session", "Cookie: " + cookie + "\r\n").body);
  EXPECT_EQ(who["state"], "in");
  EXPECT_EQ(who["name"], "vera");
  EXPECT_EQ(who["role"], "viewer");
  EXPECT_EQ(call(client, kStatus, from_page(cookie)), 0);
  EXPECT_EQ(client.get("/metrics", "Cookie: " + cookie + "\r\n").status, 200);
}

TEST_F(Entering, PassesTheBrowsersIdentityOnSoThatItsRoleCounts) {
  HttpClient client(address());
  const auto viewer = cookie_of(log_in(client, "token", token("vera", access::Role::viewer)));
  const auto reply = client.post(kHome, kGrpcWeb + from_page(viewer), framed(""));
  EXPECT_EQ(unframed(reply.body).status, kPermissionDenied);
  EXPECT_THAT(unframed(reply.body).trailers,
              testing::AllOf(HasSubstr("vera"), HasSubstr("operator")));
  const auto passing = cell.passing();  // a stop asks the axis twice
  EXPECT_EQ(call(client, "/driftwise.v1.CellService/StopAll", from_page(viewer)), 0)
      << "who may look may stop";
}

TEST_F(Entering, LogsInOnceByALink) {
  HttpClient client(address());
  const auto link =
      access->links().make({"root", access::Role::admin, access::Proof::local_socket, "", "unix:"},
                           std::chrono::steady_clock::now());
  const auto first = log_in(client, "link", link);
  ASSERT_EQ(first.status, 200) << first.body;
  EXPECT_EQ(Json::parse(first.body)["role"], "admin");
  const auto again = log_in(client, "link", link);
  EXPECT_EQ(again.status, 401);
  EXPECT_THAT(again.body, HasSubstr("used before"));
}

TEST_F(Entering, RefusesALinkWhoseTokenWasRevokedMeanwhile) {
  HttpClient client(address());
  const auto text = token("eve", access::Role::engineer);
  const auto who = access->authoriser().identify({.from = "ipv4:10.0.0.2:1", .bearer = text});
  ASSERT_TRUE(who);
  const auto now = std::chrono::steady_clock::now();
  const auto in_time = access->links().make(*who, now), late = access->links().make(*who, now);
  const auto cookie = cookie_of(log_in(client, "link", in_time));
  ASSERT_EQ(call(client, kStatus, from_page(cookie)), 0);
  ASSERT_TRUE(access->tokens().revoke(who->credential));
  const auto refused = log_in(client, "link", late);
  EXPECT_EQ(refused.status, 401);
  EXPECT_THAT(refused.body, HasSubstr("the token of 'eve' was revoked"));
  EXPECT_TRUE(refused.header("set-cookie").empty());
  const auto until = now + std::chrono::seconds(20);
  while (call(client, kStatus, from_page(cookie)) == 0 && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(call(client, kStatus, from_page(cookie)), kUnauthenticated)
      << "the session of a link ends with the token too";
}

TEST_F(Entering, MakesNoLinkOutOfASession) {
  HttpClient client(address());
  const auto cookie = cookie_of(log_in(client, "token", token("vera", access::Role::viewer)));
  const auto reply = client.post("/driftwise.v1.AccessService/CreatePageLink",
                                 kGrpcWeb + from_page(cookie), framed(""));
  EXPECT_EQ(unframed(reply.body).status, kPermissionDenied);
  EXPECT_THAT(unframed(reply.body).trailers, HasSubstr("a page session makes no further link"));
}

TEST_F(Entering, EndsASessionByLogOut) {
  HttpClient client(address());
  const auto cookie = cookie_of(log_in(client, "token", token("ada", access::Role::operator_)));
  ASSERT_EQ(call(client, kStatus, from_page(cookie)), 0);
  client.send("DELETE /session HTTP/1.1\r\nHost: " + address() + "\r\n" + from_page(cookie) +
              "\r\n");
  const auto out = client.reply();
  EXPECT_THAT(out.header("set-cookie"), HasSubstr("Max-Age=0"));
  EXPECT_EQ(Json::parse(out.body)["state"], "out");
  EXPECT_EQ(call(client, kStatus, from_page(cookie)), kUnauthenticated);
}

TEST_F(Entering, EndsASessionAndItsStreamsWhenTheTokenIsRevoked) {
  const auto passing = cell.passing();
  HttpClient client(address()), watching(address());
  const auto cookie = cookie_of(log_in(client, "token", token("ada", access::Role::operator_)));
  watching.send("POST /driftwise.v1.WatchService/Watch HTTP/1.1\r\nHost: " + address() + "\r\n" +
                kGrpcWeb + from_page(cookie) + "Content-Length: 5\r\n\r\n" + framed(""));
  EXPECT_THAT(watching.head(), StartsWith("HTTP/1.1 200"));
  EXPECT_FALSE(watching.next_chunk().empty());
  ASSERT_TRUE(access->tokens().revoke(access->tokens().list().front().id));
  std::string last;
  for (std::string chunk = watching.next_chunk(); !chunk.empty(); chunk = watching.next_chunk())
    last = chunk;
  EXPECT_EQ(unframed(last).status, kUnauthenticated);
  EXPECT_EQ(call(client, kStatus, from_page(cookie)), kUnauthenticated);
}

TEST_F(Entering, TakesACookieForACommandOnlyFromItsOwnPage) {
  HttpClient client(address());
  const auto cookie = cookie_of(log_in(client, "token", token("ada", access::Role::operator_)));
  EXPECT_EQ(call(client, kStatus, "Cookie: " + cookie + "\r\n"), kUnauthenticated)
      << "no browser says where this comes from";
  EXPECT_EQ(call(client, kStatus, "Cookie: " + cookie + "\r\nSec-Fetch-Site: same-origin\r\n"), 0);
  HttpClient foreign(address());
  EXPECT_EQ(
      foreign
          .post(kStatus, kGrpcWeb + "Origin: http://evil.example\r\nCookie: " + cookie + "\r\n",
                framed(""))
          .status,
      403);
  HttpClient form(address());
  EXPECT_EQ(form.post("/session", "Content-Type: text/plain\r\n" + from_page(""), "{}").status, 415)
      << "a form of another page can send nothing else";
}

TEST_F(Entering, TakesATokenOfAScriptWithoutACookie) {
  HttpClient client(address());
  const std::string bearer =
      "Authorization: Bearer " + token("prometheus", access::Role::viewer) + "\r\n";
  EXPECT_EQ(client.get("/metrics", bearer).status, 200);
  EXPECT_EQ(call(client, kStatus, bearer), 0);
  EXPECT_EQ(client.get("/metrics", "Authorization: Bearer dwt_wrong\r\n").status, 401);
  EXPECT_EQ(client.get("/metrics", "Authorization: Basic YTpi\r\n").status, 401);
}

TEST_F(Entering, SlowsWrongTokensAndSaysForHowLong) {
  HttpClient client(address());
  HttpReply reply;
  int tries = 0;
  for (; tries < 20 && reply.status != 429; ++tries)
    reply = log_in(client, "token", "dwt_wrong" + std::to_string(tries));
  EXPECT_EQ(reply.status, 429) << "after " << tries;
  EXPECT_FALSE(reply.header("retry-after").empty());
  EXPECT_EQ(Json::parse(reply.body)["reason"], "TOO_MANY_TRIES");
}

TEST_F(Entering, TellsNobodyWhatExists) {
  HttpClient client(address());
  const auto known = client.post(kStatus, kGrpcWeb, framed(""));
  const auto unknown = client.post("/driftwise.v1.SecretService/GetSecret", kGrpcWeb, framed(""));
  EXPECT_EQ(known.status, unknown.status);
  EXPECT_EQ(known.body, unknown.body);
  const auto secret = client.get("/../secret.txt"), missing = client.get("/../missing.txt");
  EXPECT_EQ(secret.status, missing.status);
  EXPECT_EQ(secret.body, missing.body);
}

TEST_F(Entering, HoldsNoLargeBodyOfSomebodyUnknown) {
  HttpClient client(address());
  client.send("POST /driftwise.v1.DataService/ImportDataset HTTP/1.1\r\nHost: " + address() +
              "\r\n" + kGrpcWeb + "Content-Length: 1000000\r\n\r\n");
  EXPECT_EQ(client.reply().status, 413);
}

TEST_F(Entering, TakesTheLargeBodyOfAGoodTokenAlsoWhenItIsTheFirstCallWithIt) {
  const auto send_large = [this](const std::string& bearer, const std::string& kind) {
    HttpClient client(address());
    const std::string message = framed(std::string(100'000, 'x'));  // no request: that is for later
    const auto body =
        kind == "whole" ? "Content-Length: " + std::to_string(message.size()) + "\r\n\r\n" + message
                        : "Transfer-Encoding: chunked\r\n\r\n186a5\r\n" + message + "\r\n0\r\n\r\n";
    client.send("POST /driftwise.v1.DataService/ImportDataset HTTP/1.1\r\nHost: " + address() +
                "\r\nAuthorization: Bearer " + bearer + "\r\n" + kGrpcWeb + body);
    return client.reply().status;
  };
  EXPECT_EQ(send_large(token("fresh", access::Role::operator_), "whole"), 200);
  EXPECT_EQ(send_large(token("other", access::Role::operator_), "in chunks"), 200);
  std::string local = read_file(access->token_file());
  local.pop_back();  // the line's end
  EXPECT_EQ(send_large(local, "whole"), 200) << "that of the state folder is in no book";
  EXPECT_EQ(send_large("dwt_wrong", "whole"), 401);
}

class EnteringByTls : public Entering {
 protected:
  std::unique_ptr<tls::TlsMaterial> material() override {
    certificates.emplace(folder.path());
    return std::move(*tls::TlsMaterial::open(
        {certificates->path("server.pem"), certificates->path("server-key.pem"), ""},
        tls::ClientCertificate::ignored, "http/1.1"));
  }
  AccessDescription description() override {
    auto out = Entering::description();
    out.loopback = LoopbackRule::open;  // of the plain doors: this one asks all the same
    out.names = {"cell.lab.example"};
    return out;
  }
  HttpClient client() const { return HttpClient(address(), certificates->nobody()); }

  std::optional<TestCertificates> certificates;
};

TEST_F(EnteringByTls, AsksWhoSomebodyIsAlsoWhereLoopbackIsOpen) {
  auto browser = client();
  EXPECT_EQ(browser.get("/now").status, 200);
  EXPECT_EQ(call(browser, kStatus, from_page("")), kUnauthenticated);
  const auto reply = log_in(browser, "token", token("ada", access::Role::operator_));
  EXPECT_THAT(reply.header("set-cookie"),
              testing::AllOf(StartsWith("__Host-driftwise-"), HasSubstr("; Secure")));
  EXPECT_EQ(call(browser, kStatus, from_page(cookie_of(reply))), 0);
}

TEST_F(EnteringByTls, AnswersToItsConfiguredNamesAndToPagesOfTheSameScheme) {
  const auto with_host = [&](const std::string& host, const std::string& origin) {
    auto browser = client();
    browser.send("POST /session HTTP/1.1\r\nHost: " + host + "\r\nOrigin: " + origin + "\r\n" +
                 kJson + "Content-Length: 2\r\n\r\n{}");
    return browser.reply().status;
  };
  EXPECT_EQ(with_host("cell.lab.example:8443", "https://cell.lab.example:8443"), 400)
      << "it came in, and asked for nothing";
  EXPECT_EQ(with_host("Cell.Lab.Example", "https://cell.lab.example"), 400);
  EXPECT_EQ(with_host("other.lab.example", "https://other.lab.example"), 421);
  EXPECT_EQ(with_host("cell.lab.example", "http://cell.lab.example"), 403)
      << "a plain page is another site";
}

TEST_F(EnteringByTls, TellsAPlainClientToSpeakTls) {
  HttpClient plain(address());
  plain.send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const auto reply = plain.reply();
  EXPECT_EQ(reply.status, 400);
  EXPECT_THAT(reply.body, HasSubstr("https://"));
}

TEST_F(EnteringByTls, NoticesAClientThatLeavesItsStream) {
  const auto passing = cell.passing();
  const auto admin = token("ada", access::Role::admin);
  const auto cookie = [&] {
    auto browser = client();
    return cookie_of(log_in(browser, "token", admin));
  }();
  for (int i = 0; i < 3; ++i) {
    auto watching = client();
    watching.send("POST /driftwise.v1.WatchService/Watch HTTP/1.1\r\nHost: " + address() + "\r\n" +
                  kGrpcWeb + from_page(cookie) + "Content-Length: 5\r\n\r\n" + framed(""));
    EXPECT_THAT(watching.head(), StartsWith("HTTP/1.1 200"));
    EXPECT_FALSE(watching.next_chunk().empty());
    watching.close();
  }
  auto browser = client();
  // Two requests over one connection after a stream of pieces: what was read ahead is not lost.
  for (int i = 0; i < 2; ++i) EXPECT_EQ(call(browser, kStatus, from_page(cookie)), 0);
}

TEST(PlainDoor, OutsideLoopbackIsRefusedInASentence) {
  const auto refused = web::HttpServer::open("0.0.0.0:0");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "NEEDS_TLS");
  EXPECT_THAT(refused.error().message, HasSubstr("driftwise cert init"));
}

}  // namespace
}  // namespace driftwise::tests
