// A daemon attacked through its doors, over loopback. While each attack lasts, a person's stop is
// answered. Every attack is a bounded loop.

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/data_service.grpc.pb.h"
#include "tests/integration/cell/cell_at_work.h"
#include "tests/integration/cell/peers/tcp_line.h"
#include "tests/support/http_client.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using WallClock = std::chrono::steady_clock;

double stop_s(const RunningCell& cell) {
  const auto begin = WallClock::now();
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
  v1::StopAllResponse response;
  const auto status = v1::CellService::NewStub(cell.channel())->StopAll(&context, {}, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return std::chrono::duration<double>(WallClock::now() - begin).count();
}

std::string wide_table(std::size_t columns) {
  std::string text = "time_s";
  for (std::size_t i = 1; i < columns; ++i) text += ",c" + std::to_string(i) + "_mm";
  return text + "\n1" + std::string(columns - 1, ',') + "\n";
}

double metric(const RunningCell& cell, const std::string& name) {
  HttpClient client(cell.http_address());
  const auto text = client.get("/metrics").body;
  const auto at = text.find("\n" + name + " ");
  return at == std::string::npos ? -1 : std::stod(text.substr(at + name.size() + 2));
}

std::size_t resident_mib(pid_t pid) {
  const std::string statm = read_file("/proc/" + std::to_string(pid) + "/statm");
  return std::stoul(statm.substr(statm.find(' '))) *
             static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) >>
         20;
}

TEST(Attack, ATableOf60000ColumnsDelaysNoStop) {
  CellAtWork cell;
  cell.start_daemon();
  const std::string csv = wide_table(60'000);
  std::thread importing([&] {
    auto stub = v1::DataService::NewStub(cell.channel());
    for (int i = 0; i < 5; ++i) {
      grpc::ClientContext context;
      v1::ImportDatasetRequest request;
      request.set_name("wide");
      request.set_csv(csv);
      v1::ImportDatasetResponse response;
      EXPECT_FALSE(stub->ImportDataset(&context, request, &response).ok());
    }
  });
  double slowest_s = 0;
  for (int i = 0; i < 20; ++i) slowest_s = std::max(slowest_s, stop_s(cell));
  importing.join();
  EXPECT_LT(slowest_s, 2.0);
  const double pause_s = metric(cell, "driftwise_executor_longest_pause_seconds");
  EXPECT_GE(pause_s, 0) << "the metric is there";
  EXPECT_LT(pause_s, 2.0);
  const auto refused = cell.refusal({"data", "import", cell.write("wide.csv", csv)});
  EXPECT_EQ(refused.at("reason"), "TOO_MANY_COLUMNS");
  EXPECT_EQ(refused.at("exit"), 3);
}

TEST(Attack, StreamsAndSlowRequestsLeaveRoomForAPage) {
  CellAtWork cell;
  cell.start_daemon();
  std::vector<std::unique_ptr<HttpClient>> clients;
  const std::string body = framed("");
  for (int i = 0; i < 300; ++i) {
    clients.push_back(std::make_unique<HttpClient>(cell.http_address()));
    clients.back()->send(
        i % 3 == 0 ? std::string("POST /driftwise.v1.CellService/StopAll HTTP/1.1\r\nHo")
                   : "POST /driftwise.v1.CellService/WatchEvents HTTP/1.1\r\nHost: localhost\r\n"
                     "Content-Type: application/grpc-web+proto\r\nContent-Length: 5\r\n\r\n" +
                         body);
  }
  HttpClient page(cell.http_address());
  const auto stopped = page.post("/driftwise.v1.CellService/StopAll",
                                 "Content-Type: application/grpc-web+proto\r\n", body);
  EXPECT_EQ(stopped.status, 200);
  EXPECT_EQ(unframed(stopped.body).status, 0);
  EXPECT_EQ(page.get("/healthz").status, 200);
}

TEST(Attack, AThousandIdleConnectionsLeaveDescriptorsForAll) {
  CellAtWork cell;
  cell.start_daemon();
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  const auto address = cell.grpc_address();
  peer.sin_port =
      htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  inet_pton(AF_INET, "127.0.0.1", &peer.sin_addr);
  std::vector<int> sockets;
  for (int i = 0; i < 700; ++i) {  // what this process may open itself
    sockets.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (::connect(sockets.back(), reinterpret_cast<sockaddr*>(&peer), sizeof peer) != 0) break;
  }
  EXPECT_LT(stop_s(cell), 5.0);
  EXPECT_EQ(cell.cli({"status"}).code, 0) << "a new client";
  HttpClient page(cell.http_address());
  EXPECT_EQ(page.get("/healthz").status, 200);
  EXPECT_THAT(ask_line(cell.target_line_address(), "TARGET x_mm=1"), HasSubstr("NO_MODEL"));
  std::size_t open = 0;
  for (const auto& one :
       std::filesystem::directory_iterator("/proc/" + std::to_string(cell.daemon().pid()) + "/fd"))
    open += one.path().empty() ? 0 : 1;
  EXPECT_LT(open, 400U);
  for (const int one : sockets) ::close(one);
}

TEST(Attack, UnfinishedBodiesTakeBoundedMemory) {
  CellAtWork cell;
  cell.start_daemon();
  const std::string part(std::size_t{8} << 20, 'x');
  const std::size_t before = resident_mib(cell.daemon().pid());
  std::vector<std::unique_ptr<HttpClient>> clients;
  for (int i = 0; i < 40; ++i) {
    clients.push_back(std::make_unique<HttpClient>(cell.http_address()));
    try {
      clients.back()->send(
          "POST /driftwise.v1.DataService/ImportDataset HTTP/1.1\r\nHost: localhost\r\n"
          "Content-Type: application/grpc-web+proto\r\nContent-Length: 34603008\r\n\r\n");
      clients.back()->send(part);
    } catch (const std::runtime_error&) {  // turned away in the middle
    }
  }
  EXPECT_LT(resident_mib(cell.daemon().pid()), before + 160) << "320 MiB were offered";
  EXPECT_LT(stop_s(cell), 5.0);
}

TEST(Attack, StopsInARowAreOneEventWithACount) {
  CellAtWork cell({.speed = 10});  // a burst is over after a second without a stop
  cell.start_daemon();
  for (int i = 0; i < 200; ++i) stop_s(cell);  // a thousand in process: stop_events_test.cc
  wait_until("the count", [&] { return cell.events("stop.repeated") > 0; });
  EXPECT_LE(cell.events("stop") + cell.events("stop.repeated"), 12)
      << "two, but for pauses of a busy machine";
}

TEST(Attack, NamesCommandNoTerminal) {
  CellAtWork cell;
  cell.start_daemon();
  const std::string hostile =
      "run\x1b]0;pwned\x07\nstopped by ada\xc2\x9b"
      "2J";
  const auto plan = cell.write("plan.csv", "q1_mm,dwell_s\n0,0\n0.1,1e18\n");
  EXPECT_EQ(cell.refusal({"run", "start", plan}).at("reason"), "BAD_DWELL");
  const auto data = cell.write("data.csv", "# cell: a\x1b[2J\ntime_s,q1_mm,x_mm\n1,0,0\n2,1,1\n");
  ASSERT_EQ(cell.cli({"data", "import", data, "--name", hostile, "--operator", hostile}).code, 0);
  grpc::ClientContext context;
  context.AddMetadata("driftwise-operator-bin", hostile);
  v1::StopAllResponse response;
  ASSERT_TRUE(v1::CellService::NewStub(cell.channel())->StopAll(&context, {}, &response).ok());
  wait_until("the event", [&] { return cell.events("stop") > 0; });
  for (const auto& text : {cell.say({"run", "list"}), cell.say({"events"}),
                           cell.say({"run", "list", "--json"}), cell.daemon_log()}) {
    EXPECT_EQ(text.find('\x1b'), std::string::npos) << text;
    EXPECT_EQ(text.find("\xc2\x9b"), std::string::npos) << text;
    EXPECT_EQ(text.find("\nstopped by ada"), std::string::npos) << text;
  }
  EXPECT_EQ(cell.count("SELECT COUNT(*) FROM event WHERE instr(detail, char(10)) > 0 OR "
                       "instr(detail, char(27)) > 0"),
            0);
}

}  // namespace
}  // namespace driftwise::tests
