// The autocollimators' and the load actuator's drivers against the simulated Micro-Nano, with the
// switches of what the protocol leaves open in both positions.

#include <cmath>

#include "drivers/lds1000/newport_lds1000.h"
#include "drivers/load_actuator/load_actuator.h"
#include "tests/integration/drivers/simulated_cell.h"

namespace driftwise {
namespace {

using namespace std::chrono_literals;

class AgainstTheMicroNano : public testing::Test {
 protected:
  void SetUp() override {
    if (!tests::SimulatedCell::available())
      GTEST_SKIP() << "NOT TESTED: build driftwise-cellsim first";
  }
  void start(const std::vector<std::string>& settings = {}) {
    cell = std::make_unique<tests::SimulatedCell>(settings, 200, "micro-nano");
  }
  template <class T>
  T run(Awaitable<T> work) {
    return tests::run(context, std::move(work), 30s);
  }
  std::unique_ptr<Instrument> collimator(std::map<std::string, std::string> options = {}) {
    auto description = cell->device("collimator-1");
    for (auto& [name, value] : options) description.options[name] = value;
    auto made = drivers::make_newport_lds1000(description, context.get_executor(), cell->clock());
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  asio::io_context context{1};
  std::unique_ptr<tests::SimulatedCell> cell;
};

TEST_F(AgainstTheMicroNano, ReadsTiltsInWhateverUnitTheControllerIsSetUp) {
  std::vector<double> ry_arcsec;
  for (const auto& settings : std::vector<std::vector<std::string>>{
           {"emulator.lds1000.unit=urad"},
           {"emulator.lds1000.unit=urad", "emulator.lds1000.micro_byte=\\xE6"},
           {"emulator.lds1000.unit=sec"},
           {"emulator.lds1000.unit=sec", "emulator.lds1000.decimal_comma=false"}}) {
    start(settings);
    auto device =
        collimator({{"unit", "any"}, {"increment", "0"}});  // the cell file insists on sec
    const auto reading = run(device->read());
    ASSERT_TRUE(reading) << settings.back() << ": " << reading.error().message;
    ASSERT_TRUE(reading->find("ry_arcsec") && reading->find("rz_arcsec"));
    ry_arcsec.push_back(*reading->find("ry_arcsec"));
    device->close();
  }
  // The same machine under the same sky each time: the angles agree within their noise and the
  // seconds that the reading came earlier or later.
  for (const double arcsec : ry_arcsec) EXPECT_NEAR(arcsec, ry_arcsec.front(), 0.5);
}

TEST_F(AgainstTheMicroNano, InsistsOnTheSetUpThatTheCellFileNames) {
  start({"emulator.lds1000.unit=urad"});
  auto device = collimator({{"unit", "sec"}});
  EXPECT_EQ(run(device->prepare()).error().reason, "WRONG_SET_UP");
}

TEST_F(AgainstTheMicroNano, LaysWeightsOnAndSaysWhenTheyRest) {
  start();
  auto made =
      drivers::make_load_actuator(cell->device("load"), context.get_executor(), cell->clock());
  ASSERT_TRUE(made) << made.error().message;
  auto& load = **made;
  const auto before = run(load.state());
  ASSERT_TRUE(before) << before.error().message;
  EXPECT_NEAR(before->force_n, 0, 1e-9);
  EXPECT_EQ(run(load.set_force(99)).error().reason, "NO_SUCH_LOAD");
  ASSERT_TRUE(run(load.set_force(2.305)));
  EXPECT_FALSE(run(load.state())->resting);
  const auto rested = run([](LoadActuator& actuator, Clock& clock) -> Awaitable<Result<LoadState>> {
    while (true) {
      auto state = co_await actuator.state();
      if (!state || state->resting) co_return state;
      co_await clock.sleep_for(1s);
    }
  }(load, cell->clock()));
  ASSERT_TRUE(rested) << rested.error().message;
  EXPECT_NEAR(rested->force_n, 2.305, 0.01);
}

}  // namespace
}  // namespace driftwise
