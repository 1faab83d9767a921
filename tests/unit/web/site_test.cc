// Files, headers and who may come in.

#include <fstream>
#include <iterator>
#include <regex>

#include "server/web/static_files.h"
#include "tests/unit/web/web_fixture.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class Site : public WebTest {};

TEST_F(Site, EveryViewsAddressAnswersWithThePage) {
  HttpClient client(address());
  for (const char* path : {"/", "/now", "/instruments?since=6h", "/runs/17?tab=points",
                           "/models/compare?a=11&b=12", "/record"}) {
    const auto reply = client.get(path);
    EXPECT_EQ(reply.status, 200) << path;
    EXPECT_THAT(reply.body, HasSubstr("<title>Driftwise")) << path;
    EXPECT_EQ(reply.header("content-type"), "text/html; charset=utf-8");
    EXPECT_EQ(reply.header("cache-control"), "no-cache");
  }
  EXPECT_EQ(client.get("/nowhere").status, 404);
}

TEST_F(Site, KeepsHashedFilesForEverAndPacksThem) {
  HttpClient client(address());
  const auto whole = client.get("/assets/index-BWqQ7d2x.js");
  EXPECT_EQ(whole.body, "console.log('whole')");
  EXPECT_EQ(whole.header("content-type"), "text/javascript; charset=utf-8");
  EXPECT_THAT(whole.header("cache-control"), HasSubstr("immutable"));
  const auto packed = client.get("/assets/index-BWqQ7d2x.js", "Accept-Encoding: gzip, br\r\n");
  EXPECT_EQ(packed.body, "packed");
  EXPECT_EQ(packed.header("content-encoding"), "gzip");
  EXPECT_NE(packed.header("etag"), whole.header("etag"));
  EXPECT_EQ(client.get("/assets/index-BWqQ7d2x.js", "Accept-Encoding: gzip;q=0\r\n").body,
            whole.body);
}

TEST_F(Site, AnswersAKnownFileWithNotModified) {
  HttpClient client(address());
  const auto first = client.get("/favicon.svg");
  EXPECT_EQ(first.header("content-type"), "image/svg+xml");
  const auto again = client.get("/favicon.svg", "If-None-Match: " + first.header("etag") + "\r\n");
  EXPECT_EQ(again.status, 304);
  EXPECT_EQ(client.get("/favicon.svg").status, 200);  // the connection is still in step
}

TEST_F(Site, ServesNothingOutsideItsFolder) {
  std::filesystem::create_symlink(folder.path() + "/secret.txt", root() + "/link.txt");
  write_file(root() + "/.hidden", "not for you");
  HttpClient client(address());
  for (const char* path :
       {"/../secret.txt", "/%2e%2e/secret.txt", "/assets/../../secret.txt", "/..%2fsecret.txt",
        "/assets/..%5c..%5csecret.txt", "//etc/passwd", "/link.txt", "/.hidden", "/assets", "/%00",
        "/%zz", "/now/%2e%2e/%2e%2e/secret.txt"})
    EXPECT_THAT(client.get(path).body, testing::Not(HasSubstr("not for you"))) << path;
}

TEST_F(Site, SaysWhatABrowserMayDoWithItsPages) {
  HttpClient client(address());
  for (const char* path : {"/", "/healthz", "/nowhere", "/favicon.svg"}) {
    const auto reply = client.get(path);
    EXPECT_THAT(reply.header("content-security-policy"), StartsWith("default-src 'none'"));
    EXPECT_EQ(reply.header("x-content-type-options"), "nosniff");
    EXPECT_EQ(reply.header("referrer-policy"), "no-referrer");
  }
}

TEST_F(Site, RefusesForeignNamesAndForeignPages) {
  const auto passing = cell.passing();  // a stop asks the axis twice
  HttpClient client(address());
  const std::string call = "/driftwise.v1.CellService/StopAll";
  const auto with_host = [&](const std::string& host) {
    client.send("GET / HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    return client.reply().status;
  };
  EXPECT_EQ(with_host("evil.example"), 421);
  EXPECT_EQ(with_host("localhost.evil.example:80"), 421);
  EXPECT_EQ(with_host("10.0.0.7:8080"), 421);
  EXPECT_EQ(with_host("localhost:9999"), 200);  // through a tunnel
  EXPECT_EQ(with_host("[::1]:8080"), 200);
  const auto with_origin = [&](const std::string& header) {
    HttpClient fresh(address());
    return fresh.post(call, kGrpcWeb + header, framed("")).status;
  };
  EXPECT_EQ(with_origin("Origin: http://evil.example\r\n"), 403);
  EXPECT_EQ(with_origin("Origin: null\r\n"), 403);
  EXPECT_EQ(with_origin("Origin: http://localhost:1\r\n"), 403);
  EXPECT_EQ(with_origin("Sec-Fetch-Site: cross-site\r\n"), 403);
  const std::string ours = "Origin: http://" + address() + "\r\n";
  EXPECT_EQ(with_origin(ours + "Origin: http://evil.example\r\n"), 400) << "the first is ours";
  EXPECT_EQ(with_origin("Sec-Fetch-Site: none\r\nSec-Fetch-Site: cross-site\r\n"), 400);
  EXPECT_EQ(cell.on_executor([&] { return cell.world.stops; }), 0) << "nothing came through";
  EXPECT_EQ(with_origin("Origin: http://" + address() + "\r\n"), 200);
  EXPECT_EQ(with_origin(""), 200);
}

TEST_F(Site, TellsHealthAndMetricsOfTheCell) {
  HttpClient client(address());
  EXPECT_EQ(client.get("/healthz").body, "ok\n");
  EXPECT_THAT(client.get("/metrics").body, HasSubstr("cell=\"small\""));
}

TEST_F(Site, AnswersAHeadWithoutABody) {
  HttpClient client(address());
  client.send("HEAD /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(client.reply(true).header("content-length"), "3");
  EXPECT_EQ(client.get("/healthz").body, "ok\n");
}

TEST_F(Site, RefusesWhatIsNoRequestAndCloses) {
  for (const std::string& bytes :
       {std::string("nonsense\r\n\r\n"),
        "GET / HTTP/1.1\r\nHost: localhost\r\nX: " + std::string(20'000, 'x') + "\r\n\r\n"}) {
    HttpClient client(address());
    client.send(bytes);
    EXPECT_THAT(client.reply().status, testing::AnyOf(400, 431));
    EXPECT_TRUE(client.closed());
  }
  HttpClient client(address());
  client.send("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nhello");
  EXPECT_EQ(client.reply().status, 405);
  EXPECT_TRUE(client.closed());
}

TEST_F(Site, MakesRoomForTheNextClient) {
  std::vector<std::unique_ptr<HttpClient>> idle;
  for (std::size_t i = 0; i < web::HttpServer::kMaxConnections; ++i)
    idle.push_back(std::make_unique<HttpClient>(address()));
  idle.back()->get("/healthz");  // the server has taken all of them
  HttpClient late(address());
  EXPECT_EQ(late.get("/healthz").status, 200);
}

TEST_F(Site, WithoutAPageSaysHowToGetOne) {
  std::filesystem::remove(root() + "/index.html");
  HttpClient client(address());
  EXPECT_THAT(client.get("/now").body, HasSubstr("--web-root"));
  EXPECT_EQ(client.get("/healthz").status, 200);
}

// The page's own list of views is the judge: one that the server does not know is gone at a reload.
TEST(ViewAddress, EveryViewOfThePageIsAnswered) {
  std::ifstream in(std::string(DRIFTWISE_SOURCE_DIR) + "/clients/web/src/app/views.ts");
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const std::regex name("\\{ name: '([a-z]+)'");
  int views = 0;
  for (std::sregex_iterator at(text.begin(), text.end(), name), end; at != end; ++at, ++views) {
    EXPECT_TRUE(web::is_view_address("/" + (*at)[1].str())) << (*at)[1];
    EXPECT_TRUE(web::is_view_address("/" + (*at)[1].str() + "/1")) << (*at)[1];
  }
  EXPECT_GE(views, 14);
  EXPECT_FALSE(web::is_view_address("/nothing"));
}

}  // namespace
}  // namespace driftwise::tests
