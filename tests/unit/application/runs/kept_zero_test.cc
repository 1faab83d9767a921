// A length whose zero is kept in the daemon, as of a touch probe, over a restart within a line.

#include <gmock/gmock.h>

#include <algorithm>

#include "server/application/motion/datum_opening.h"
#include "server/core/data/row_marks.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/own_instrument.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

// Shows the place of the axis, 1 mm off.
class ProbeOfTheDaemon final : public OwnInstrument {
 public:
  ProbeOfTheDaemon(SmallWorld& world, VirtualTime& time, DeviceDescription description)
      : OwnInstrument(
            time, std::move(description), 0.25,
            [this, &world] {
              return std::vector<ChannelValue>{{"x_mm", shown_mm(world) - zero_mm_.value_or(0)}};
            }),
        world_(world) {}
  Awaitable<Result<void>> zero() override {
    zero_mm_ = shown_mm(world_);
    co_return Result<void>{};
  }
  bool knows_its_zero() const override { return zero_mm_.has_value(); }

 private:
  double shown_mm(SmallWorld& world) const {
    constexpr double kOffset_mm = 1, kNoise_mm = 1e-6;
    return world.to_mm + kOffset_mm + kNoise_mm * world.gauss();
  }
  SmallWorld& world_;
  std::optional<double> zero_mm_;
};

TEST(ZeroKeptInTheDaemon, IsNotComparedAfterARestartAndNoRowIsSuspect) {
  Folder folder;
  SmallWorld world;
  const auto description = small_cell(folder / "cell.sqlite");
  const CellInMemory::MakeDevices with_probe = [&world](VirtualTime& time,
                                                        const CellDescription& cell) {
    auto devices = small_devices(world, time, cell);
    devices[2] = std::make_unique<ProbeOfTheDaemon>(world, time, cell.devices[2]);
    return devices;
  };
  RunId run;
  CellInMemory::Further later;
  {
    CellInMemory cell(with_probe, description, kSqlite, {});
    run = cell.begin_run(lines_of(2, {-4, -2, 1, 3}, true)).id;
    cell.until([&] { return cell.status().run->run.accepted == 3; });
    later.begin = cell.now() + std::chrono::seconds(60);
  }  // ends within the first line
  CellInMemory cell(with_probe, description, kSqlite, std::move(later));
  const auto done = cell.finish_run();
  EXPECT_EQ(done.state, RunState::done) << done.reason;
  const auto data = cell.await(cell.datums(run));
  ASSERT_EQ(data->size(), 2U);
  EXPECT_EQ(application::find_value(data->back().values, "zero_found_nm"), nullptr)
      << "the old zero went with the daemon";
  EXPECT_THAT(cell.events_named("zero.surprising"), testing::IsEmpty());
  const auto dataset =
      cell.await(cell.read([run](Store& store) { return store.runs().dataset(std::vector{run}); }));
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(std::ranges::count(dataset->excluded, kSuspectRow), 0);
  EXPECT_EQ(std::ranges::count(dataset->excluded, kPassageRow), 1) << "the zero of the restart";
}

}  // namespace
}  // namespace driftwise::tests
