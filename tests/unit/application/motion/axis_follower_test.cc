// An instrument whose reading depends on how an axis has moved: it learns where the axis is, and
// when nobody knows that.

#include "server/core/ports/control/axis_follower.h"

#include <gtest/gtest.h>

#include "server/core/devices/voltage_sensors.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/own_instrument.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

// The direction of the dry friction of q1, as the force of its motor needs it.
class MotorOfTheAxis final : public OwnInstrument, public AxisFollower {
 public:
  MotorOfTheAxis(VirtualTime& time, DeviceDescription description)
      : OwnInstrument(time, std::move(description), 0.05, [] {
          return std::vector<ChannelValue>{{"motor_force_N", 3.0}};
        }) {}
  const Channel& followed_axis() const override { return axis_; }
  void axis_at(double q_mm) override { direction_.moved_to(q_mm); }
  void axis_unknown() override { direction_.forget(); }
  int direction() const { return direction_.now(); }

 private:
  Channel axis_{"q1", "mm"};
  FrictionDirection direction_{0.02};
};

class FollowedAxis : public testing::Test {
 protected:
  CellDescription described() {
    auto out = small_cell(folder / "cell.sqlite");
    DeviceDescription motor_of_q1;
    motor_of_q1.id = "motor";
    motor_of_q1.kind = "keithley-2701";
    motor_of_q1.address = "127.0.0.1:1";
    motor_of_q1.period_s = 5;
    motor_of_q1.become<ForceSettings>().quantities = {{{"motor_force", "N"}, 0.01}};
    out.devices.push_back(motor_of_q1);
    return out;
  }
  CellInMemory::MakeDevices with_the_motor() {
    return [this](VirtualTime& time, const CellDescription& description) {
      auto devices = small_devices(world, time, description);
      auto made = std::make_unique<MotorOfTheAxis>(time, description.devices.back());
      motor = made.get();
      devices.push_back(std::unique_ptr<Instrument>(std::move(made)));
      return devices;
    };
  }
  void jog_to(double q_mm) {
    ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {q_mm})));
    cell.pass(20);
  }

  Folder folder;
  SmallWorld world;
  MotorOfTheAxis* motor = nullptr;
  CellInMemory cell{with_the_motor(), described(), kSqlite, {}};
};

TEST_F(FollowedAxis, HasADirectionUntilItIsHomedAndFromItsNextWayOn) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  jog_to(1);
  jog_to(-0.5);
  EXPECT_EQ(motor->direction(), -1);
  // Homing goes from -0.5 to 0, upwards; a counter that was 1.7 mm off then says nothing of it.
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  EXPECT_EQ(motor->direction(), 0) << "a jump of the counter is no motion";
  cell.pass(20);
  EXPECT_EQ(motor->direction(), 0);
  jog_to(1);
  EXPECT_EQ(motor->direction(), 1);
}

TEST_F(FollowedAxis, HasNoDirectionAfterItsControllerWasAway) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  jog_to(1);
  EXPECT_EQ(motor->direction(), 1);
  world.axis_away = true;
  cell.pass(20);
  world.axis_away = false;
  cell.pass(20);
  EXPECT_EQ(motor->direction(), 0);
}

}  // namespace
}  // namespace driftwise::tests
