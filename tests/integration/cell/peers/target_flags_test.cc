// Targets that should not be trusted: flagged, and refused where the cell says so.

#include <gmock/gmock.h>

#include "tests/integration/cell/cell_at_work.h"
#include "tests/integration/cell/peers/tcp_line.h"
#include "tests/integration/cell/served_model.h"

namespace driftwise::tests {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;

void wait_for_temperatures(const CellAtWork& cell) {
  wait_until("a target without flags for its temperatures", [&] {
    const auto flags = cell.ask({"target", "x=1"}).at("flags").dump();
    return flags.find("temperature") == std::string::npos;
  });
}

TEST(TargetFlags, NameTheSilentThermometerAndGoWhenItIsMended) {
  CellAtWork cell;
  cell.start_daemon();
  serve_known_model(cell);
  wait_for_temperatures(cell);
  const double before = cell.ask({"target", "x=1"}).at("coordinates").at(0).at("u_nm");
  cell.control("fault open-probe 105");
  wait_until("the flag", [&] {
    return cell.ask({"target", "x=1"}).at("flags").dump().find("stale_temperature") !=
           std::string::npos;
  });
  const auto stale = cell.ask({"target", "x=1"});
  EXPECT_THAT(stale.at("stale_channels"), Contains("t05_degC"));
  EXPECT_GT(stale.at("coordinates").at(0).at("u_nm").get<double>(), before);
  EXPECT_THAT(ask_line(cell.target_line_address(), "TARGET x_mm=1"),
              HasSubstr("STALE_TEMPERATURE(t05_degC)"));
  EXPECT_THAT(cell.say({"status"}), HasSubstr("t05"));
  cell.control("fault mend-probe 105");
  wait_for_temperatures(cell);
}

TEST(TargetFlags, SayThatThePoseLiesOutsideTheDomain) {
  CellAtWork cell;
  cell.start_daemon();
  serve_known_model(cell);
  wait_for_temperatures(cell);
  const auto inside = cell.ask({"target", "x=3.9"}), outside = cell.ask({"target", "x=4.4"});
  EXPECT_THAT(inside.at("flags").dump(), testing::Not(HasSubstr("outside_domain")));
  EXPECT_THAT(outside.at("flags"), Contains("outside_domain"));
  EXPECT_THAT(outside.at("outside_channels"), Contains("x_mm"));
  EXPECT_GT(outside.at("coordinates").at(0).at("u_nm").get<double>(),
            inside.at("coordinates").at(0).at("u_nm").get<double>());
}

TEST(TargetFlags, RefuseWhatTheAxisCannotReachAndShowItToPeople) {
  CellAtWork cell;  // its axis travels from -4.5 to 4.5 mm
  cell.start_daemon();
  serve_known_model(cell);
  wait_for_temperatures(cell);
  EXPECT_THAT(ask_line(cell.target_line_address(), "TARGET x_mm=-801"),
              StartsWith("ERR OUTSIDE_LIMITS(q1) q1_mm = -80"));
  EXPECT_THAT(ask_line(cell.target_line_address(), "TARGET x_mm=1 rx_arcsec=2"),
              HasSubstr("IGNORED_COORDINATE(rx_arcsec)"));
  const auto shown = cell.cli({"target", "x=-801", "--json"});
  EXPECT_EQ(shown.code, 1) << "the answer is that it cannot be reached";
  const auto target = nlohmann::json::parse(shown.out);
  EXPECT_THAT(target.at("flags"), Contains("outside_limits"));
  EXPECT_THAT(target.at("unreachable_channels"), Contains("q1_mm"));
  EXPECT_LT(target.at("coordinates").at(0).at("position_mm").get<double>(), -800);
  EXPECT_THAT(cell.cli({"target", "x=-801"}).out, HasSubstr("not reachable"));
}

TEST(TargetFlags, OnlyNameTheLimitsWhereTheCellFileSaysSo) {
  CellAtWork cell;
  cell.edit_cell_file("refuse_outside_domain = false",
                      "refuse_outside_domain = false\nrefuse_outside_limits = false");
  cell.start_daemon();
  serve_known_model(cell);
  wait_for_temperatures(cell);
  const auto answer = ask_line(cell.target_line_address(), "TARGET x_mm=-801");
  EXPECT_THAT(answer, StartsWith("OK q1_mm=-80"));
  EXPECT_THAT(answer, HasSubstr("OUTSIDE_LIMITS(q1)"));
}

TEST(TargetFlags, BecomeRefusalsWhereTheCellSaysSo) {
  CellAtWork cell;
  cell.edit_cell_file("refuse_stale = false", "refuse_stale = true");
  cell.edit_cell_file("refuse_outside_domain = false", "refuse_outside_domain = true");
  cell.start_daemon();
  serve_known_model(cell);
  wait_until("an accepted target", [&] { return cell.cli({"target", "x=1"}).code == 0; });

  const auto outside = cell.refusal({"target", "x=4.5"});
  EXPECT_EQ(outside.at("exit"), 5);
  EXPECT_EQ(outside.at("reason"), "OUTSIDE_DOMAIN");
  EXPECT_THAT(outside.at("message").get<std::string>(), HasSubstr("x_mm"));
  EXPECT_THAT(ask_line(cell.target_line_address(), "TARGET x_mm=4.5"),
              StartsWith("ERR OUTSIDE_DOMAIN"));

  cell.control("fault open-probe 105");
  wait_until("a refused target", [&] { return cell.cli({"target", "x=1"}).code != 0; });
  const auto stale = cell.refusal({"target", "x=1"});
  EXPECT_EQ(stale.at("exit"), 5);
  EXPECT_EQ(stale.at("reason"), "STALE");
  EXPECT_THAT(stale.at("message").get<std::string>(), HasSubstr("t05_degC"));
  EXPECT_THAT(ask_line(cell.target_line_address(), "TARGET x_mm=1"), StartsWith("ERR STALE"));
  cell.control("fault mend-probe 105");
  wait_until("an accepted target", [&] { return cell.cli({"target", "x=1"}).code == 0; });
}

}  // namespace
}  // namespace driftwise::tests
