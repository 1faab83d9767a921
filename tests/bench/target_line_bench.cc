// The text line against a bare Asio echo: round trips of one client over loopback, seven
// interleaved pairs in one run. Prints one JSON line; goal: p99 at most 1.3 x the echo's (median
// over the pairs).
//   taskset -c 1 build/release/bin/target_line_bench [round trips per half pair, default 5000]

#include <algorithm>
#include <array>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "server/compensation/snapshot_builder.h"
#include "server/line/target_line_server.h"
#include "tests/support/manual_clock.h"
#include "tests/unit/compensation/models.h"

namespace {

using namespace driftwise;
using asio::ip::tcp;
using boost::system::error_code;

constexpr int kPairs = 7;
constexpr std::string_view kRequest = "TARGET x_mm=1.234567 u=1\n";

// What any answer over a socket costs at least, in the same style: callbacks, one read, one write.
class Echo : public std::enable_shared_from_this<Echo> {
 public:
  explicit Echo(tcp::socket socket) : socket_(std::move(socket)) {
    socket_.set_option(tcp::no_delay(true));
  }
  void read_on() {
    socket_.async_read_some(
        asio::buffer(in_), [self = shared_from_this()](error_code error, std::size_t count) {
          if (!error)
            asio::async_write(self->socket_, asio::buffer(self->in_.data(), count),
                              [self](error_code failed, std::size_t) {
                                if (!failed) self->read_on();
                              });
        });
  }

 private:
  tcp::socket socket_;
  std::array<char, 2048> in_;
};

class Client {
 public:
  explicit Client(std::uint16_t port) : socket_(context_) {
    socket_.connect(tcp::endpoint(asio::ip::address_v4::loopback(), port));
    socket_.set_option(tcp::no_delay(true));
  }
  double round_trip_us() {
    const auto start = std::chrono::steady_clock::now();
    asio::write(socket_, asio::buffer(kRequest));
    char answer[1024];
    std::size_t size = 0;
    do size += socket_.read_some(asio::buffer(answer + size, sizeof answer - size));
    while (answer[size - 1] != '\n');
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start)
        .count();
  }

 private:
  asio::io_context context_;
  tcp::socket socket_;
};

struct Quantiles {
  double p50_us, p99_us;
};
Quantiles measure(Client& client, int round_trips) {
  std::vector<double> times;
  for (int i = 0; i < round_trips; ++i) times.push_back(client.round_trip_us());
  std::ranges::sort(times);
  return {times[times.size() / 2], times[times.size() * 99 / 100]};
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const int round_trips = argc > 1 ? std::max(100, std::atoi(argv[1])) : 5000;
  asio::io_context context;
  const auto work = asio::make_work_guard(context);
  const tests::ManualClock clock;
  compensation::SnapshotBoard board;
  auto builder = std::move(*compensation::SnapshotBuilder::create(
      compensation::axis_model(), ModelId{1}, compensation::axis_cell()));
  if (!board.publish(builder.build(clock.now().utc))) return 1;
  const auto access = *access::Access::open({}, "/nonexistent");  // an open loopback, no tokens
  auto server = std::move(*line::TargetLineServer::start(
      {context.get_executor(), context.get_executor(), board, clock, *access}, {"127.0.0.1:0"}));
  tcp::acceptor acceptor(context, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  acceptor.async_accept([](error_code error, tcp::socket socket) {
    if (!error) std::make_shared<Echo>(std::move(socket))->read_on();
  });
  std::thread thread([&] { context.run(); });

  const auto& address = server->address();
  Client line(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)))),
      echo(acceptor.local_endpoint().port());
  measure(line, 500), measure(echo, 500);  // warm
  std::vector<double> line_p50, line_p99, echo_p50, echo_p99, ratios;
  for (int pair = 0; pair < kPairs; ++pair) {
    const auto a = measure(pair % 2 ? line : echo, round_trips),
               b = measure(pair % 2 ? echo : line, round_trips);
    const auto& of_line = pair % 2 ? a : b;
    const auto& of_echo = pair % 2 ? b : a;
    line_p50.push_back(of_line.p50_us), line_p99.push_back(of_line.p99_us);
    echo_p50.push_back(of_echo.p50_us), echo_p99.push_back(of_echo.p99_us);
    ratios.push_back(of_line.p99_us / of_echo.p99_us);
  }
  std::printf(
      "{\"pairs\": %d, \"round_trips\": %d, \"echo_p50_us\": %.1f, \"echo_p99_us\": %.1f, "
      "\"line_p50_us\": %.1f, \"line_p99_us\": %.1f, \"p99_ratio\": %.3f}\n",
      kPairs, round_trips, median(echo_p50), median(echo_p99), median(line_p50), median(line_p99),
      median(ratios));
  asio::post(context, [&] {
    server.reset();
    context.stop();
  });
  thread.join();
  return 0;
}
