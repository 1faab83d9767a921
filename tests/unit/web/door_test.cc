// The web door under attack, over real sockets on loopback: a new page and its Stop come in
// whatever the others do. Each attack is a bounded loop. The site behind the door is the smallest
// that has a page, a stop and a stream.

#include <gmock/gmock.h>
#include <sys/socket.h>

#include <atomic>
#include <boost/asio/post.hpp>
#include <stdexcept>
#include <thread>

#include "server/application/plumbing/signal.h"
#include "server/web/http_server.h"
#include "server/web/security_headers.h"
#include "tests/support/hostile.h"
#include "tests/support/http_client.h"

namespace driftwise::tests {
namespace {

const std::string kStop = "/driftwise.v1.CellService/StopAll";
const std::string kWatch = "/driftwise.v1.CellService/WatchEvents";
constexpr std::size_t kFull = web::HttpServer::kMaxConnections + 40;
constexpr std::size_t kMostBody = std::size_t{33} << 20;

// One piece at once, then nothing until somebody raises the news.
class Watched final : public web::BodyStream {
 public:
  Watched(asio::any_io_executor executor, std::shared_ptr<std::vector<Watched*>> all)
      : news_(std::move(executor)), all_(std::move(all)) {
    all_->push_back(this);
  }
  ~Watched() override { std::erase(*all_, this); }
  Awaitable<Piece> next() override {
    while (!fresh_ && !abandoned_) co_await news_.wait();
    fresh_ = false;
    co_return Piece{"news", abandoned_};
  }
  void abandon() override {
    abandoned_ = true;
    news_.raise();
  }
  void tell() {
    fresh_ = true;
    news_.raise();
  }

 private:
  application::Signal news_;
  std::shared_ptr<std::vector<Watched*>> all_;
  bool fresh_ = true, abandoned_ = false;
};

class SmallSite final : public web::HttpSite {
 public:
  SmallSite(asio::any_io_executor executor, std::atomic<int>& stops,
            std::shared_ptr<std::vector<Watched*>> watched)
      : executor_(std::move(executor)), stops_(stops), watched_(std::move(watched)) {}
  Awaitable<Admitted> admit(const web::HttpRequest&) override { co_return kMostBody; }
  Awaitable<web::HttpResponse> answer(web::HttpRequest request) override {
    if (request.path() == kStop) ++stops_;
    web::HttpResponse response = web::plain_answer(200, "page\n");
    if (request.path() == kWatch) {
      response.body.clear();
      response.stream = std::make_shared<Watched>(executor_, watched_);
    }
    co_return response;
  }

 private:
  asio::any_io_executor executor_;
  std::atomic<int>& stops_;
  std::shared_ptr<std::vector<Watched*>> watched_;
};

class Door : public testing::Test {
 protected:
  Door() : http(std::move(*web::HttpServer::open("127.0.0.1:0"))) {
    http->serve(std::make_unique<SmallSite>(http->executor(), stops, watched));
  }
  ~Door() override {
    clients.clear();
    http.reset();
  }

  std::string address() const { return http->address(); }
  std::string post(const std::string& path, std::size_t length) const {
    return "POST " + path + " HTTP/1.1\r\nHost: " + address() +
           "\r\nContent-Length: " + std::to_string(length) + "\r\n\r\n";
  }
  HttpClient& open_client() {
    clients.push_back(std::make_unique<HttpClient>(address()));
    return *clients.back();
  }
  // To all streams, on the web thread.
  void tell_streams() {
    std::atomic<bool> told = false;
    asio::post(http->executor(), [&] {
      for (auto* one : *watched) one->tell();
      told = true;
    });
    while (!told) std::this_thread::yield();
  }
  // As a person with a browser that was opened just now.
  void expect_a_new_page_and_its_stop() {
    const int before = stops;
    const auto begin = std::chrono::steady_clock::now();
    HttpClient page(address());
    EXPECT_EQ(page.get("/").status, 200);
    EXPECT_EQ(page.post(kStop, "", "stop").status, 200);
    EXPECT_EQ(stops, before + 1);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  }

  std::atomic<int> stops = 0;
  std::shared_ptr<std::vector<Watched*>> watched = std::make_shared<std::vector<Watched*>>();
  std::unique_ptr<web::HttpServer> http;
  std::vector<std::unique_ptr<HttpClient>> clients;
};

TEST_F(Door, StaysOpenForAPageWhileStreamsFillIt) {
  for (std::size_t i = 0; i < kFull; ++i) open_client().send(post(kWatch, 0));
  expect_a_new_page_and_its_stop();
}

TEST_F(Door, StaysOpenForAPageWhileSlowRequestsFillIt) {
  for (std::size_t i = 0; i < kFull; ++i)
    open_client().send("POST " + kStop + " HTTP/1.1\r\nHost: loc");
  expect_a_new_page_and_its_stop();
}

TEST_F(Door, HoldsConnectionsWithinTheQuota) {
  for (std::size_t i = 0; i < kFull; ++i) open_client();
  expect_a_new_page_and_its_stop();
  std::size_t closed = 0;
  for (std::size_t i = 0; i < kFull - web::HttpServer::kMaxPerPeer; ++i)
    closed += clients[i]->closed() ? 1 : 0;
  EXPECT_EQ(closed, kFull - web::HttpServer::kMaxPerPeer) << "the longest idle ones";
  EXPECT_EQ(clients.back()->get("/").status, 200) << "the newest one is served";
}

TEST_F(Door, KeepsTheStreamThatIsRead) {
  HttpClient page(address());
  page.send(post(kWatch, 0));
  page.head();
  EXPECT_EQ(page.next_chunk(), "news");
  for (std::size_t i = 0; i < kFull; ++i) open_client();
  expect_a_new_page_and_its_stop();
  tell_streams();
  EXPECT_EQ(page.next_chunk(), "news") << "idle connections made room";
}

// 12 bodies of 16 MiB that are never finished: 192 MiB that nobody may make the daemon hold.
TEST_F(Door, HoldsABoundedPartOfUnfinishedBodies) {
  const std::string part(std::size_t{16} << 20, 'x');
  const std::size_t before = resident_bytes();
  std::size_t most = before;
  int turned_away = 0;
  for (int i = 0; i < 12; ++i) {
    try {
      open_client().send(post("/file", kMostBody));
      clients.back()->send(part);
    } catch (const std::runtime_error&) {  // in the middle
      ++turned_away;
    }
    most = std::max(most, resident_bytes());
  }
  EXPECT_LT(most - before, std::size_t{150} << 20) << turned_away << " were turned away";
  expect_a_new_page_and_its_stop();
}

}  // namespace
}  // namespace driftwise::tests
