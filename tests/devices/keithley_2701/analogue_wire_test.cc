// The scanner's devices against driftwise-cellsim: one connection, thermometers and voltages in
// turn, and what the plant says is true.

#include <cmath>

#include "drivers/all_devices.h"
#include "drivers/pi_gcs/pi_gcs.h"
#include "server/core/ports/control/axis_follower.h"
#include "server/core/ports/made_device.h"
#include "tests/devices/keithley_2701/analogue_cells.h"
#include "tests/integration/drivers/simulated_cell.h"

namespace driftwise::tests {
namespace {

using namespace std::chrono_literals;

class AnalogueDrivers : public testing::Test {
 protected:
  void SetUp() override {
    if (!SimulatedCell::available()) GTEST_SKIP() << "NOT TESTED: build driftwise-cellsim first";
  }
  void start(const std::string& from, const char* cell_text, const char* plant_text,
             const std::string& found = "", const std::string& instead = "") {
    files = std::make_unique<LargerCell>(from, cell_text, plant_text, found, instead);
    cell = std::make_unique<SimulatedCell>(std::vector<std::string>{"emulator.scanner.slot2=7700"},
                                           50, files->name());
  }
  template <class T>
  T run(Awaitable<T> work) {
    return tests::run(context, std::move(work), 30s);
  }
  MadeDevice make(const std::string& id) {
    const auto description = cell->device(id);
    auto made = find_kind(drivers::all_devices(), description.kind)
                    ->make(description, {context.get_executor(), cell->clock(), {}, shared});
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  Reading read(const MadeDevice& device) {
    const auto reading = run(device.as<Instrument>()->read());
    EXPECT_TRUE(reading) << reading.error().message;
    return reading ? *reading : Reading{};
  }
  void move_to(const MadeDevice& robot, std::vector<double> q_mm, AxisFollower* follower) {
    auto& controller = *robot.as<MotionController>();
    const auto started = run(controller.start_move(std::move(q_mm)));
    ASSERT_TRUE(started) << started.error().message;
    for (int i = 0; i < 100000; ++i) {
      const auto state = run(controller.state());
      ASSERT_TRUE(state) << state.error().message;
      if (follower) follower->axis_at(state->q_mm.front());
      if (!state->moving && state->on_target) return;
    }
    FAIL() << "the robot does not arrive";
  }

  asio::io_context context{1};
  std::unique_ptr<LargerCell> files;
  std::unique_ptr<SimulatedCell> cell;
  std::shared_ptr<SharedByAddress> shared = std::make_shared<SharedByAddress>();
};

TEST_F(AnalogueDrivers, PlateAndInclinometerAgreeThroughOneScanner) {
  start("min-angle", kPlateAndLevel, kSensorsOfThePlant);
  EXPECT_EQ(cell->address("plate"), cell->address("scanner")) << "one emulated scanner";
  const auto scanner = make("scanner"), plate = make("plate"), level = make("servo-level"),
             robot = make("robot");
  ASSERT_TRUE(run(robot.as<MotionController>()->home()));
  ASSERT_TRUE(run(plate.as<Instrument>()->zero()));
  const auto level_zero = read(level), plate_zero = read(plate);
  EXPECT_NEAR(*plate_zero.find("z_mm"), 0, 0.002);
  move_to(robot, {1.5, -0.5, -0.5}, nullptr);
  const auto temperatures = read(scanner);
  EXPECT_EQ(temperatures.values.size(), 10u);
  EXPECT_NEAR(*temperatures.find("t05_degC"), 21, 8);
  const auto tilted = read(plate), leaning = read(level);
  const double by_plate = *tilted.find("rx_arcsec") - *plate_zero.find("rx_arcsec");
  const double by_level = *leaning.find("rx_arcsec") - *level_zero.find("rx_arcsec");
  EXPECT_GT(std::hypot(by_plate, *tilted.find("ry_arcsec")), 3000) << "about a degree";
  // 0.1 mV of noise: 1.4 arcsec of the level, 0.9 of the plate; twice each, at three sigma 10.
  EXPECT_NEAR(by_plate, by_level, 10);
}

TEST_F(AnalogueDrivers, TheForceOfAMotorIsTheSameFromBothSidesOfItsFriction) {
  start("micro-nano", kForcesAndConfirmation, kForcesOfThePlant, kSeesRx, kSeesRxAndRz);
  const auto scanner = make("scanner"), motor = make("motor-1"), robot = make("robot");
  auto* follower = dynamic_cast<AxisFollower*>(&motor.device());
  ASSERT_NE(follower, nullptr);
  ASSERT_TRUE(run(robot.as<MotionController>()->home()));
  const auto unknown = read(motor);
  EXPECT_EQ(*unknown.find("motor_force_dead_band_1"), 1);
  EXPECT_NEAR(*unknown.find("motor_force_N"), 0, 3 * *unknown.find("motor_force_u_N"));
  // A peak of the ring-down that the follower happens to see is a reversal: the driver then says
  // that it does not know the direction, and the force is anywhere within the friction of 0.4 N.
  const auto at_1_mm_from = [&](double start_mm) {
    for (int approach = 0; approach < 10; ++approach) {
      move_to(robot, {start_mm, 0, 0}, follower);
      move_to(robot, {1, 0, 0}, follower);
      auto reading = read(motor);
      if (*reading.find("motor_force_dead_band_1") == 0) return reading;
      EXPECT_NEAR(*reading.find("motor_force_N"), 2, 0.42);
      EXPECT_GT(*reading.find("motor_force_u_N"), 0.2) << "0.4 N / sqrt(3)";
    }
    return Reading{};
  };
  const auto upwards = at_1_mm_from(0), downwards = at_1_mm_from(2);
  ASSERT_FALSE(upwards.values.empty() || downwards.values.empty())
      << "the direction is not known after ten approaches";
  for (const auto* one : {&upwards, &downwards})
    EXPECT_NEAR(*one->find("motor_force_N"), 2, 0.02) << "2 N/mm at 1 mm";
  // The servo's ring-down eases the friction by a percent or two.
  EXPECT_NEAR(*upwards.find("motor_1_202_V") - *downwards.find("motor_1_202_V"), 2 * 0.4 / 4, 0.006)
      << "the hysteresis is in the voltage";
}

}  // namespace
}  // namespace driftwise::tests
