// Forces of a sensor join a point from its own rest, never from the motion.

#include <gtest/gtest.h>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/own_instrument.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

constexpr double kOfMotion_n = 50;
constexpr double kNoise_n = 1e-6;  // no two answers are equal

class ForceAtRest : public testing::Test {
 protected:
  // 1 N/mm while the axis stands.
  CellDescription cell_with_spring(double period_s) {
    auto cell = small_cell(folder / "cell.sqlite");
    DeviceDescription spring;
    spring.id = "spring";
    spring.kind = "keithley-2701";
    spring.address = "127.0.0.1:1";
    spring.period_s = period_s;
    spring.max_age_s = 30;
    VoltageSensor sensor;
    sensor.channel = {"spring_force", "N"};
    sensor.input = 201;
    sensor.min_v = -100;
    sensor.max_v = 100;
    sensor.slope = 1;
    spring.voltages.sensors = {sensor};
    spring.become<ForceSettings>().quantities = {{{"spring_force", "N"}, 0.01}};
    cell.devices.push_back(spring);
    return cell;
  }
  CellInMemory::MakeDevices with_spring() {
    return [this](VirtualTime& time, const CellDescription& cell) {
      auto devices = small_devices(world, time, cell);
      devices.push_back(
          std::make_unique<OwnInstrument>(time, cell.devices.back(), 0.07, [this, &time] {
            ++asked;
            const auto q_mm = standing_at_mm(world, time);
            const double force_n = q_mm.value_or(kOfMotion_n) + kNoise_n * world.gauss();
            return std::vector<ChannelValue>{{"spring_force_N", is_out ? kMissing : force_n}};
          }));
      return devices;
    };
  }
  std::vector<PointRecord> points_of_a_run(double period_s) {
    CellInMemory cell(with_spring(), cell_with_spring(period_s), kSqlite, {});
    const auto run = cell.begin_run(lines_of(3, {-4, 4, -3, 3, -4, 4}, true));
    EXPECT_EQ(cell.finish_run().state, RunState::done);
    took_s = seconds_from(cell.now() - kWorldBegin);
    return *cell.await(cell.points(run.id, 0, 1000));
  }
  static const double* force_of(const PointRecord& point) {
    for (const auto& value : point.values)
      if (value.channel == "spring_force_N") return &value.value;
    return nullptr;
  }

  Folder folder;
  SmallWorld world;
  int asked = 0;
  bool is_out = false;  // of its range
  double took_s = 0;
};

TEST_F(ForceAtRest, IsReadAtThePointWhereItsOwnPeriodIsLongerThanTheRest) {
  const auto points = points_of_a_run(7);
  ASSERT_GE(points.size(), 18U);
  for (const auto& point : points) {
    const auto* force_n = force_of(point);
    ASSERT_NE(force_n, nullptr) << "row " << point.row + 1;
    // The reference run puts the scale some nanometres off.
    EXPECT_NEAR(*force_n, point.commanded_mm[0], 1e-3) << "row " << point.row + 1;
  }
}

TEST_F(ForceAtRest, IsNotAskedForAgainWhereAScanOfTheRestIsThere) {
  const auto points = points_of_a_run(0.25);
  for (const auto& point : points) {
    const auto* force_n = force_of(point);
    ASSERT_NE(force_n, nullptr);
    EXPECT_NEAR(*force_n, point.commanded_mm[0], 1e-3);
  }
  EXPECT_LE(asked, took_s / 0.25 + 2);
}

TEST_F(ForceAtRest, ThatIsMissingJoinsNoPointAndHoldsUpNone) {
  is_out = true;
  const auto points = points_of_a_run(7);
  ASSERT_GE(points.size(), 18U);
  for (const auto& point : points) EXPECT_EQ(force_of(point), nullptr);
}

}  // namespace
}  // namespace driftwise::tests
