// The daemon's other doors: HTTP for those who watch machines; gRPC's health and reflection for
// those who know no proto file.

#include <gmock/gmock.h>

#include "tests/integration/cell/cell_at_work.h"
#include "tests/integration/cell/peers/tcp_line.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(HttpDoor, TellsHealthAndMetrics) {
  CellAtWork cell;
  cell.start_daemon();
  ASSERT_NE(cell.http_address(), "");
  const auto get = [&](const std::string& path) {
    return ask_to_end(cell.http_address(),
                      "GET " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  };
  EXPECT_THAT(get("/healthz"), StartsWith("HTTP/1.1 200"));
  wait_until("the temperatures", [&] { return get("/metrics").find("t05") != std::string::npos; });
  const auto metrics = get("/metrics");
  EXPECT_THAT(metrics, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(metrics, HasSubstr("# TYPE driftwise_"));
  EXPECT_THAT(get("/nothing"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(ask_to_end(cell.http_address(), "nonsense\r\n\r\n"), testing::Not(HasSubstr("200")));
  EXPECT_EQ(cell.stop_daemon(), 0);
}

TEST(GrpcDoor, TellsHealthAndItsServicesToWhoKnowsNoProtoFile) {
  CellAtWork cell;
  cell.start_daemon();
  const auto told =
      run_process({"/usr/bin/python3",
                   std::string(DRIFTWISE_SOURCE_DIR) +
                       "/tests/integration/peers/health_and_reflection_from_python.py",
                   cell.grpc_address()},
                  std::chrono::seconds(60), {"no_grpc_proxy=127.0.0.1"});
  if (told.code == 77) GTEST_SKIP() << "python3-grpcio is missing: health and reflection not asked";
  ASSERT_EQ(told.code, 0) << told.err;
  const auto json = nlohmann::json::parse(told.out);
  EXPECT_EQ(json.at("health"), "SERVING");
  EXPECT_EQ(json.at("health_of_run_service"), "SERVING");
  for (const char* service :
       {"CellService", "RunService", "DataService", "ModelService", "TargetService"})
    EXPECT_THAT(json.at("services"), testing::Contains(std::string("driftwise.v1.") + service));
}

}  // namespace
}  // namespace driftwise::tests
