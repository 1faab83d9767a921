// The quick part of the table of lies: one channel of each kind, twice the smallest size. The whole
// table: driftwise_lies (docs/evidence/lies.md).

#include <gtest/gtest.h>

#include "storage/sqlite_store.h"
#include "tests/faults/lies/lie_table.h"

namespace driftwise::lies {
namespace {

void expect_all_found(const std::string& cell, const std::vector<std::string>& channels) {
  LieBench bench(cell);
  for (const auto& name : channels) {
    const auto found = std::ranges::find(bench.channels(), name, &ChannelOfCell::name);
    ASSERT_NE(found, bench.channels().end()) << name;
    for (const Kind kind : kKinds) {
      const auto entry = measure(bench, *found, kind, Effort::quick);
      EXPECT_EQ(entry.problem, "")
          << cell << " " << name << " " << name_of(kind) << " " << entry.size.value_or(0) << ": "
          << entry.at_twice.how << " after " << entry.at_twice.after_s
          << " s: " << entry.at_twice.said;
    }
  }
}

TEST(Lies, LinearAxis) {
  expect_all_found("linear-axis",
                   {"q1_mm", "x_mm", "air_degC", "t04_degC", "t07_degC", "support_degC"});
}
TEST(Lies, MicroNano) { expect_all_found("micro-nano", {"q2_mm", "y_mm", "ry_arcsec", "force_N"}); }

TEST(Lies, AnInterferometerThatIsNotZeroAfterItsZeroingOpensNoDatum) {
  constexpr double kOff_mm = 0.96e-3;
  tests::Folder folder;
  auto world = tests::make_plant_world("linear-axis", tests::kWorldBegin, 1, true);
  tests::CellInMemory cell(
      [&world](tests::VirtualTime& time, const CellDescription& described) {
        return tests::plant_devices(world, time, described);
      },
      tests::shipped_cell("linear-axis", folder / "cell.db"),
      [](const std::string& path, bool read_only) {
        return storage::open_sqlite_store(path, read_only);
      },
      tests::CellInMemory::Further{});
  world.liar.tell(
      "x_mm", [](double value, CellTime) { return value + kOff_mm; }, true);
  cell.begin_run("q1_mm,set,line,zero\n1,calibration,1,0\n0,calibration,1,1\n");
  const auto progress = [&cell] { return cell.status().run; };
  cell.until([&] { return progress() && progress()->run.state == RunState::waiting; });
  EXPECT_NE(progress()->run.reason.find("right after it was zeroed"), std::string::npos)
      << progress()->run.reason;
  const auto tries = [&cell] { return cell.events_named("run.trouble").size(); };
  cell.pass(7200);
  EXPECT_EQ(progress()->run.accepted, 0);
  EXPECT_LT(tries(), 20U) << "it is asked less and less often";
  world.liar.stop();
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST(Lies, TrueDevicesRaiseNoAlarm) {
  for (const char* cell : {"linear-axis", "micro-nano"})
    EXPECT_EQ(LieBench(cell).tell_the_truth(20), std::vector<std::string>{}) << cell;
}

}  // namespace
}  // namespace driftwise::lies
