// A bench with a second controller, which no [[robot]] names.

#include <gtest/gtest.h>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

// A controller whose axis stands still.
class StillController final : public MotionController {
 public:
  StillController(DeviceDescription description, VirtualTime& time, int& stops)
      : description_(std::move(description)), time_(time), stops_(stops) {}
  const DeviceDescription& description() const override { return description_; }
  DeviceHealth health() const override { return {}; }
  Awaitable<Result<void>> prepare() override { co_return Result<void>{}; }
  void close() override {}
  Awaitable<Result<MotionState>> state() override {
    co_return MotionState{time_.now().utc, {0.0}, false, true, true};
  }
  Awaitable<Result<void>> home() override { co_return Result<void>{}; }
  Awaitable<Result<void>> start_move(std::span<const double>) override { co_return Result<void>{}; }
  Awaitable<Result<void>> stop() override {
    ++stops_;
    co_return Result<void>{};
  }

 private:
  DeviceDescription description_;
  VirtualTime& time_;
  int& stops_;
};

DeviceDescription controller_of(const std::string& id, const std::string& channel_symbol) {
  DeviceDescription device;
  device.id = id;
  device.kind = "pi-gcs";
  device.become<MotionSettings>().axes = {{{channel_symbol, "mm"}, "X", -1, 1, 0}};
  return device;
}

TEST(SeveralControllers, AreHeldShownAndStopped) {
  Folder folder;
  SmallWorld world;
  int stops = 0;
  auto description = small_cell(folder / "cell.sqlite");
  description.devices.push_back(controller_of("hexapod", "mn.q1"));
  const auto make = [&](VirtualTime& time, const CellDescription& described) {
    auto devices = small_devices(world, time, described);
    devices.push_back(std::make_unique<StillController>(described.devices.back(), time, stops));
    return devices;
  };
  CellInMemory cell(make, description, kSqlite, {});
  cell.pass(10);
  const auto status = cell->overview.status();
  ASSERT_EQ(status.devices.size(), 5U);
  EXPECT_EQ(status.devices[0].description.id, "axis");
  EXPECT_EQ(status.devices[1].description.id, "hexapod");
  const auto stopped = cell.await(cell->manual.stop_all(cell.ada));
  ASSERT_TRUE(stopped) << stopped.error().message;
  EXPECT_GE(stops, 1);
  EXPECT_GE(world.stops, 1);
}

}  // namespace
}  // namespace driftwise::tests
