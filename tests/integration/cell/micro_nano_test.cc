// Three axes, tilts and a force on the wire: from a plan to a compensated target.

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <regex>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

const CellOptions kMicroNano{.speed = 200, .cell = "micro-nano"};

// A small version of the published plan: grids under two forces, and one for validation between.
std::string small_plan(const CellAtWork& cell) {
  const auto file = cell.folder() + "/plan.csv";
  cell.say({"trajectory", "grid", "--axes", "q1,q2,q3", "--block", "calibration 0:2:1 force=0",
            "--block", "validation 0.5:1.5:1 force=0.768", "--block",
            "calibration 0:2:1 force=2.305", "-o", file});
  return file;
}

// Points of the plan: what else moved the axes is a passage.
nlohmann::json points_of(const CellAtWork& cell, std::int64_t run) {
  const auto said = cell.ask({"run", "points", std::to_string(run)});
  auto planned = nlohmann::json::array();
  for (const auto& point : said.is_array() ? said : said.at("points"))
    if (!point.value("passage", false)) planned.push_back(point);
  return planned;
}

double value(const nlohmann::json& point, const std::string& channel) {
  return point.at("values").at(channel).get<double>();
}

void take_the_actuator_away(const CellAtWork& cell) {
  const auto path = cell.folder() + "/cell.toml";
  std::ifstream in(path);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto from = text.find("[[device]]\nid = \"load\"");
  ASSERT_NE(from, std::string::npos);
  text.erase(from, text.find("\n\n", from) - from);
  cell.write("cell.toml", text);
}

void expect_pose_beside_paths(const nlohmann::json& point) {
  for (const std::string axis : {"x", "y", "z"}) {
    // The levers are some millimetres, the tilts below an arcminute: up to a few micrometres.
    const double correction_mm = value(point, axis + "_mm") - value(point, axis + "_path_mm");
    EXPECT_LT(std::abs(correction_mm), 10e-3) << point;
    EXPECT_LT(std::abs(value(point, "r" + axis + "_arcsec")), 200) << point;
    EXPECT_LE(value(point, axis + "_std_nm"), 20) << "the gate of the cell file";
    EXPECT_TRUE(point.at("values").contains("air_" + axis + "_degC"));
  }
}

TEST(MicroNano, GoesFromAPlanToACompensatedTarget) {
  CellAtWork cell(kMicroNano);
  cell.start_daemon();
  const auto watched = cell.cli({"run", "start", small_plan(cell), "--watch"});
  ASSERT_EQ(watched.code, 0) << watched.err << cell.daemon_log();
  const auto points = points_of(cell, 1);
  ASSERT_EQ(points.size(), 2u * (27 + 9) + 8 + 4);
  double largest_correction_mm = 0;
  for (const auto& point : points) {
    expect_pose_beside_paths(point);
    largest_correction_mm =
        std::max(largest_correction_mm, std::abs(value(point, "x_mm") - value(point, "x_path_mm")));
  }
  EXPECT_GT(largest_correction_mm, 1e-6) << "the correction stage did something";
  EXPECT_NEAR(value(points.front(), "force_N"), 0, 0.02);
  EXPECT_NEAR(value(points.back(), "force_N"), 2.305, 0.02);
  EXPECT_EQ(cell.events("load.changed"), 3) << "0 N, 2.305 N, and 0 N at the end";
  // The stored readings keep what each device said, under its own channel.
  EXPECT_GT(cell.count("SELECT count(*) FROM reading JOIN device USING (device_id) "
                       "WHERE device.name = 'collimator-1'"),
            0);

  const auto fit = cell.ask({"fit", "--run", "1", "--model", "q ~ poly(x, y, z, 2) + F"});
  cell.say({"model", "promote", std::to_string(fit.at("model_id").get<int>()), "--yes"});
  const auto poses = cell.folder() + "/poses.csv";
  cell.say({"trajectory", "grid", "--axes", "q1,q2,q3", "--block",
            "validation 0.3:1.7 scattered=6 force=0.768", "--to-pose", cell.folder() + "/cell.toml",
            "-o", poses});
  const auto moved = cell.cli({"run", "start", poses, "--compensate", "--watch"});
  ASSERT_EQ(moved.code, 0) << moved.err << cell.daemon_log();
  for (const auto& point : points_of(cell, 2))
    for (const std::string axis : {"x", "y", "z"})
      // A second-order model of a delta over 2 mm leaves some micrometres of the third order.
      EXPECT_NEAR(value(point, axis + "_mm"), value(point, axis + "_target_mm"), 5e-3) << point;
}

TEST(MicroNano, WaitsForThePersonWhoHangsTheWeightsOverAKill) {
  CellAtWork cell(kMicroNano);
  take_the_actuator_away(cell);
  cell.start_daemon();
  const auto plan = cell.folder() + "/forces.csv";
  cell.say({"trajectory", "grid", "--axes", "q1,q2,q3", "--block",
            "calibration 0:1:1 q2=0:0:1 q3=0:0:1 force=0", "--block",
            "calibration 0:1:1 q2=0:0:1 q3=0:0:1 force=2.305", "-o", plan});
  const auto run = cell.ask({"run", "start", plan}).at("id").get<std::int64_t>();
  const auto number = std::to_string(run);
  const auto reason = [&] { return cell.run(run).value("reason", std::string()); };
  wait_until("the prompt for 0 N", [&] { return reason().starts_with("take every weight off"); });
  const auto wrong = cell.refusal({"run", "confirm", number, "--force", "1"});
  EXPECT_EQ(wrong.at("reason"), "WRONG_FORCE");
  cell.say({"run", "confirm", number, "--force", "0"});
  wait_until("the prompt for 2.305 N",
             [&] { return reason().starts_with("hang 2.305 N (235 g), then: driftwise run"); });
  EXPECT_EQ(cell.state_of(run), "waiting");
  cell.kill_daemon();
  cell.start_daemon();
  wait_until("the prompt again", [&] { return reason().starts_with("hang 2.305 N (235 g)"); });
  cell.say({"run", "confirm", number, "--force", "2.305"});
  wait_until("the prompt at the end",
             [&] { return reason().starts_with("take every weight off"); });
  cell.say({"run", "confirm", number, "--force", "0"});
  EXPECT_EQ(cell.end_of(run).at("state"), "done");
  const auto points = points_of(cell, run);
  ASSERT_EQ(points.size(), 8u) << "two lines of one point and its return to zero, twice";
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_EQ(value(points[i], "force_N"), i < 4 ? 0 : 2.305);
  EXPECT_EQ(cell.events("load.confirmed"), 3);
}

}  // namespace
}  // namespace driftwise::tests
