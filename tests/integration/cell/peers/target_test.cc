// One target, the same to the last digit by whatever door it is asked for; and a stream that
// follows the temperatures.

#include <gmock/gmock.h>
#include <grpcpp/channel.h>

#include <regex>

#include "driftwise/v1/target_service.grpc.pb.h"
#include "tests/integration/cell/cell_at_work.h"
#include "tests/integration/cell/peers/tcp_line.h"
#include "tests/integration/cell/served_model.h"

namespace driftwise::tests {
namespace {

struct Answer {
  double q1_mm = 0;
  std::string conditions;  // when the snapshot was made, where the door tells it
};

Answer by_command_line(const CellAtWork& cell) {
  const auto target = cell.ask({"target", "x=1.234567"});
  return {target.at("coordinates").at(0).at("position_mm"), target.at("conditions_time")};
}

double by_text_line(const CellAtWork& cell) {
  const auto line = ask_line(cell.target_line_address(), "TARGET x_mm=1.234567");
  std::smatch number;
  if (!std::regex_search(line, number, std::regex("q1_mm=([^ ]+)")))
    throw std::runtime_error("target line: " + line);
  return std::stod(number[1]);
}

double by_grpc(const CellAtWork& cell) {
  grpc::ClientContext context;
  v1::ComputeTargetRequest request;
  auto& pose = *request.add_pose();
  pose.set_channel("x_mm");
  pose.set_value(1.234567);
  v1::ComputeTargetResponse response;
  const auto status =
      v1::TargetService::NewStub(cell.channel())->ComputeTarget(&context, request, &response);
  if (!status.ok()) throw std::runtime_error(status.error_message());
  return response.target().coordinates(0).position_mm();
}

std::optional<double> by_python(const CellAtWork& cell) {
  const std::string source = DRIFTWISE_SOURCE_DIR;
  const auto done = run_process({"/usr/bin/python3", source + "/clients/examples/python/target.py",
                                 cell.grpc_address(), source + "/proto", "x_mm=1.234567"},
                                std::chrono::seconds(60), {"no_grpc_proxy=127.0.0.1"});
  if (done.code == 77) return std::nullopt;
  if (done.code != 0) throw std::runtime_error("target.py: " + done.err);
  return nlohmann::json::parse(done.out).at("q1_mm").get<double>();
}

TEST(Target, IsTheSameByEveryDoor) {
  CellAtWork cell;
  cell.edit_cell_file("rebuild_period_s = 5.0", "rebuild_period_s = 3600.0");
  cell.start_daemon();
  ASSERT_EQ(cell.end_of(cell.start_run(campaign(3, 6))).at("state"), "done");
  const auto fit = cell.ask({"fit", "--run", "1", "--model", "q ~ x + x^2 + t05"});
  cell.say({"model", "promote", std::to_string(fit.at("model_id").get<int>()), "--yes"});
  // No new temperatures: the conditions stay what they are long enough to ask four times.
  cell.control("fault mute scanner 1000000 s");
  bool one_snapshot = false, python_is_here = true;
  for (int tries = 0; tries < 20 && !one_snapshot; ++tries) {
    const auto first = by_command_line(cell);
    const double line = by_text_line(cell), grpc = by_grpc(cell);
    const auto python = by_python(cell);
    const auto last = by_command_line(cell);
    one_snapshot = first.conditions == last.conditions;
    if (!one_snapshot) continue;
    python_is_here = python.has_value();
    EXPECT_EQ(first.q1_mm, last.q1_mm);
    EXPECT_EQ(line, first.q1_mm);
    EXPECT_EQ(grpc, first.q1_mm);
    if (python) {
      EXPECT_EQ(*python, first.q1_mm);
    }
  }
  EXPECT_TRUE(one_snapshot) << "the conditions never stood still for the time of four questions";
  if (!python_is_here)
    GTEST_SKIP() << "python3-grpcio, python3-protobuf or protoc is missing: three doors agree, "
                    "the fourth was not asked";
}

TEST(Target, FollowsTheTemperatures) {
  // A room that gets 8 K warmer at once: the robot's base follows within minutes.
  CellAtWork cell({.speed = 400, .cellsim_options = {"--set", "room.schedule=[[0.01, 28.0]]"}});
  cell.start_daemon();
  serve_known_model(cell);
  auto watch = cell.cli_process({"target", "x=1", "--watch", "--json"});
  struct Seen {
    double q1_mm, t05_degc;
  };
  std::vector<Seen> seen;
  while (seen.empty() || std::abs(seen.back().t05_degc - seen.front().t05_degc) < 0.1) {
    const auto line = watch.read_line(std::chrono::seconds(60));
    ASSERT_TRUE(line) << cell.daemon_log();
    const auto target = nlohmann::json::parse(*line);
    if (!target.at("missing_channels").empty()) continue;  // not yet read
    // What an outsider finds in the database as the newest scan of that instant; it is stored with
    // some delay.
    const std::string instant = target.at("conditions_time");
    const auto latest = "FROM reading_wide WHERE device = 'scanner' AND t05_degC IS NOT NULL";
    wait_until("a scan stored after " + instant, [&] {
      return cell.count(std::string("SELECT count(*) ") + latest + " AND start_utc > '" + instant +
                        "'") > 0;
    });
    const auto t05 = cell.sql(std::string("SELECT t05_degC ") + latest + " AND start_utc <= '" +
                              instant + "' ORDER BY start_ns DESC LIMIT 1");
    if (t05.empty()) continue;
    seen.push_back({target.at("coordinates").at(0).at("position_mm"), std::stod(t05)});
  }
  watch.signal(SIGINT);
  ASSERT_GE(seen.size(), 2u);
  const double moved_mm = seen.back().q1_mm - seen.front().q1_mm;
  const double warmed_k = seen.back().t05_degc - seen.front().t05_degc;
  // The scan that the snapshot had may be one before or after the one found: a few mK.
  EXPECT_NEAR(moved_mm, kServedMmPerKelvin * warmed_k, 0.02 * kServedMmPerKelvin);
}

}  // namespace
}  // namespace driftwise::tests
