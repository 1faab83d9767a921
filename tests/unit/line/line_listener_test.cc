// A text line's socket and the network interface that it belongs to, in two network namespaces that
// the test makes. Skipped where the kernel gives none.

#include "server/line/line_listener.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <future>
#include <string>
#include <thread>

#include "server/line/line_address.h"
#include "tests/unit/line/captured_log.h"

namespace driftwise::line {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

// A thread in a network of its own.
class OtherNetwork {
 public:
  OtherNetwork() {
    run([this] {
      tid_ = ::gettid();
      there_ = ::unshare(CLONE_NEWNET) == 0 && ip("link set lo up");
    });
  }
  ~OtherNetwork() {
    work_.reset();
    thread_.join();
  }
  bool there() const { return there_; }
  std::string tid() const { return std::to_string(tid_); }
  asio::io_context& context() { return context_; }
  void run(std::function<void()> work) {
    std::promise<void> done;
    asio::post(context_, [&] {
      work();
      done.set_value();
    });
    done.get_future().wait();
  }
  // In this thread's network: within run().
  static bool ip(const std::string& arguments) {
    return std::system(("ip " + arguments + " 2>/dev/null").c_str()) == 0;
  }

 private:
  asio::io_context context_;
  asio::executor_work_guard<asio::io_context::executor_type> work_{context_.get_executor()};
  std::thread thread_{[this] { context_.run(); }};
  pid_t tid_ = 0;
  bool there_ = false;
};

class ListenerOnAnInterface : public testing::Test {
 protected:
  void SetUp() override {
    if (!here.there() || !far.there()) GTEST_SKIP() << "NO NETWORK NAMESPACE: not tested here";
  }
  bool plug() {
    bool good = true;
    here.run([&] {
      good = OtherNetwork::ip("link add cal0 type veth peer name far0 netns " + far.tid()) &&
             OtherNetwork::ip("addr add 10.77.198.1/30 dev cal0") &&
             OtherNetwork::ip("link set cal0 up");
    });
    far.run([&] {
      good = good && OtherNetwork::ip("addr add 10.77.198.2/30 dev far0") &&
             OtherNetwork::ip("link set far0 up");
    });
    return good;
  }
  void pull() {
    here.run([] { OtherNetwork::ip("link del cal0"); });
  }
  // Within half a minute.
  bool enters(std::uint16_t port) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    const int before = taken;
    while (std::chrono::steady_clock::now() < until) {
      far.run([&] {
        asio::io_context context;
        tcp::socket socket(context);
        boost::system::error_code error;
        socket.connect({asio::ip::make_address("10.77.198.1"), port}, error);
      });
      if (taken > before) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }

  tests::CapturedLog log;
  OtherNetwork here, far;
  std::atomic<int> taken = 0;
};

TEST_F(ListenerOnAnInterface, WaitsForItAndFollowsItWhenItComesBack) {
  std::shared_ptr<LineListener> listener;
  boost::system::error_code error;
  here.run([&] {
    listener = std::make_shared<LineListener>(here.context().get_executor(),
                                              *endpoint_from("10.77.198.1:50053"), "cal0");
    error = listener->open();
    listener->begin([&](tcp::socket) { ++taken; });
  });
  EXPECT_FALSE(error) << error.message();
  EXPECT_NE(log.text().find("no network interface 'cal0' now"), std::string::npos);
  ASSERT_TRUE(plug());
  EXPECT_TRUE(enters(50053)) << log.text();
  pull();
  ASSERT_TRUE(plug());
  EXPECT_TRUE(enters(50053)) << "it is another interface to the kernel: " << log.text();
  here.run([&] { listener->shut(); });
  pull();
}

TEST_F(ListenerOnAnInterface, IsRefusedWhereThePortIsTaken) {
  boost::system::error_code error;
  here.run([&] {
    asio::io_context other;
    tcp::acceptor taken_port(other, {asio::ip::make_address("127.0.0.1"), 50053});
    auto listener = std::make_shared<LineListener>(here.context().get_executor(),
                                                   *endpoint_from("127.0.0.1:50053"), "lo");
    error = listener->open();
    listener->shut();
  });
  EXPECT_EQ(error, boost::system::errc::address_in_use);
}

}  // namespace
}  // namespace driftwise::line
