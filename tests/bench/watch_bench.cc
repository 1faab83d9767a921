// What those who watch cost: the small cell's channels, 20 updates a second, 0, 1 and 10 clients of
// Watch over loopback, each for some seconds.
//
//   watch_bench [seconds]      prints one JSON object
//
// executor: the thread that runs the cell; what it spends is what a run could feel. process: all
// threads, clients included.

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <time.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "driftwise/v1/watch_service.grpc.pb.h"
#include "server/rpc/server/rpc_server.h"
#include "tests/support/fakes.h"

namespace {

using namespace driftwise;
using tests::FakeFeeds;
using tests::LiveCell;

double cpu_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

struct Client {
  Client(const std::string& address, std::atomic<std::int64_t>& batches)
      : thread([this, address, &batches] {
          auto stub = v1::WatchService::NewStub(
              grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
          v1::WatchRequest request;
          request.set_max_hz(20);
          const auto reader = stub->Watch(&context, request);
          for (v1::WatchResponse batch; reader->Read(&batch);) ++batches;
          reader->Finish();
        }) {}
  ~Client() {
    context.TryCancel();
    thread.join();
  }
  grpc::ClientContext context;
  std::thread thread;
};

nlohmann::ordered_json measure(LiveCell& cell, FakeFeeds& feeds, const std::string& address,
                               int clients, double seconds) {
  std::atomic<std::int64_t> batches{0};
  std::vector<std::unique_ptr<Client>> watching;
  for (int i = 0; i < clients; ++i) watching.push_back(std::make_unique<Client>(address, batches));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const auto executor_now = [&] {
    return cell.on_executor([] { return cpu_s(CLOCK_THREAD_CPUTIME_ID); });
  };
  const double executor = executor_now(), process = cpu_s(CLOCK_PROCESS_CPUTIME_ID);
  batches = 0;
  const auto begin = std::chrono::steady_clock::now();
  const auto end = begin + std::chrono::duration<double>(seconds);
  for (int i = 0; std::chrono::steady_clock::now() < end; ++i) {
    if (i % 20 == 0) cell.add_event("bench");
    cell.on_executor([&] {
      feeds.readings.publish({"scanner", tests::kWorldBegin, tests::kWorldBegin, i, {}});
      if (i % 20 == 0) feeds.records.publish();
    });
    std::this_thread::sleep_until(begin + std::chrono::milliseconds(50) * (i + 1));
  }
  return {
      {"clients", clients},
      {"batches_per_s", static_cast<double>(batches) / seconds},
      {"executor_percent_of_a_core", 100 * (executor_now() - executor) / seconds},
      {"process_percent_of_a_core", 100 * (cpu_s(CLOCK_PROCESS_CPUTIME_ID) - process) / seconds}};
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::stod(argv[1]) : 10;
  LiveCell cell;
  FakeFeeds feeds;
  auto server = rpc::RpcServer::open(cell.services({.feeds = &feeds}), "127.0.0.1:0");
  if (!server) return 1;
  (*server)->ready(true);
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const int clients : {0, 1, 10})
    out.push_back(measure(cell, feeds, (*server)->address(), clients, seconds));
  std::puts(out.dump(2).c_str());
  return 0;
}
