// Runs in measuring set-ups: only the instruments that a set-up names are read and required.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/ports/run_plan.h"
#include "server/core/data/measured_by.h"
#include "server/core/try.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// The autocollimator beside the small world's axis: ry = 20 arcsec per mm, seen within 30 arcsec.
struct TiltWorld {
  bool away = false;         // carried to another set-up
  bool breaks_beam = false;  // the interferometer loses its beam beyond 1.2 mm
  int readings = 0;
  double zero_arcsec = 3, wrong_per_mm = 0;  // of what it reads
};
class Tilts final : public Instrument {
 public:
  Tilts(TiltWorld& tilts, SmallWorld& world, VirtualTime& time, DeviceDescription description)
      : tilts_(tilts), world_(world), time_(time), description_(std::move(description)) {}
  const DeviceDescription& description() const override { return description_; }
  DeviceHealth health() const override { return {}; }
  void close() override {}
  Awaitable<Result<void>> prepare() override { co_return co_await answer(); }
  Awaitable<Result<void>> zero() override {
    co_return fail(ErrorCode::failed_precondition, "NO_ZERO", "tilts: it has none");
  }
  Awaitable<Result<Reading>> read() override {
    const auto start = time_.now().utc;
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await answer());
    ++tilts_.readings;
    if (tilts_.breaks_beam && std::abs(world_.to_mm) > 1.2) world_.beam_lost = true;
    const double ry = (20 + tilts_.wrong_per_mm) * world_.to_mm + tilts_.zero_arcsec;
    if (std::abs(ry) > 30)
      co_return fail(ErrorCode::failed_precondition, "NO_SPOT", "tilts: the spot is outside");
    co_return Reading{description_.id,
                      start,
                      time_.now().utc,
                      ++sequence_,
                      {{"ry_arcsec", ry + 0.01 * world_.gauss()}}};
  }

 private:
  Awaitable<Result<void>> answer() {
    co_await time_.sleep_until(time_.now().utc + nanoseconds_from_s(0.1));
    if (tilts_.away)
      co_return fail(ErrorCode::unavailable, "LINK_DOWN", "tilts: connection refused");
    co_return Result<void>{};
  }
  TiltWorld& tilts_;
  SmallWorld& world_;
  VirtualTime& time_;
  DeviceDescription description_;
  std::int64_t sequence_ = 0;
};

SetupDescription setup(const std::string& name, std::vector<SetupCoordinate> coordinates) {
  return {name, "", std::move(coordinates)};
}

class Setups : public testing::Test {
 protected:
  // confirmed: with a second autocollimator of the same angle, and a set-up that it confirms.
  explicit Setups(bool confirmed = false)
      : cell([this](VirtualTime& time, const CellDescription& of) { return devices_of(time, of); },
             description(folder / "cell.sqlite", confirmed), kSqlite, CellInMemory::Further{}) {}

  application::Devices devices_of(VirtualTime& time, const CellDescription& of) {
    auto devices = small_devices(world, time, of);
    devices.push_back(std::make_unique<Tilts>(tilts, world, time, *of.find_device("tilts")));
    if (const auto* second = of.find_device("tilts-2"))
      devices.push_back(std::make_unique<Tilts>(second_tilts, world, time, *second));
    return devices;
  }
  static CellDescription description(const std::string& database, bool confirmed) {
    auto cell = small_cell(database);
    DeviceDescription tilts = cell.devices[2];
    tilts.id = "tilts";
    tilts.kind = "lds1000";
    tilts.channels = {{"ry", "arcsec"}};
    tilts.settings = AngleSettings{{{{"ry", "arcsec"}, 1, 1, 0.1}}};
    cell.devices.push_back(tilts);
    cell.setups = {setup("length", {{{"x", "mm"}, "laser-x", 1.0005, 0, {}, {}}}),
                   setup("tilt", {{{"ry", "arcsec"}, "tilts", 1, 0, {}, {}}}),
                   setup("both", {{{"x", "mm"}, "laser-x", 1, 0, {}, {}},
                                  {{"ry", "arcsec"}, "tilts", 1, 0, -30.0, 30.0}}),
                   setup("near", {{{"x", "mm"}, "laser-x", 1, 0, -1.2, 1.2},
                                  {{"ry", "arcsec"}, "tilts", 1, 0, {}, {}}})};
    if (confirmed) {
      tilts.id = "tilts-2";
      cell.devices.push_back(tilts);
      cell.setups.push_back(setup("sure", {{{"x", "mm"}, "laser-x", 1, 0, {}, {}},
                                           {{"ry", "arcsec"}, "tilts", 1, 0, {}, {}}}));
      cell.setups.back().confirmations = {{{"ry", "arcsec"}, "tilts-2", 1, 0, 0.5}};
    }
    for (const auto& one : cell.setups) {  // as a file would have them
      cell.text += "[[setup]]\nname = \"" + one.name + "\"\n";
      for (const auto& coordinate : one.coordinates)
        cell.text += "[[setup.coordinate]]\nchannel = \"" + coordinate.channel.name() +
                     "\"\ndevice = \"" + coordinate.device + "\"\n";
    }
    return cell;
  }
  Result<RunRecord> try_in(const std::string& setup, const std::string& trajectory) {
    application::CreateRun request;
    request.name = request.trajectory_name = "plan.csv";
    request.trajectory_text = trajectory;
    request.setup = setup;
    return cell.try_run(request);
  }
  RunRecord measure_in(const std::string& setup, const std::string& trajectory) {
    const auto begun = try_in(setup, trajectory);
    if (!begun) throw std::runtime_error(begun.error().message);
    return cell.finish_run();
  }
  std::vector<std::string> channels_of(RunId run) {
    const auto data = cell.await(cell.read([run](Store& store) {
      return store.runs().dataset({&run, 1});
    }));
    std::vector<std::string> names;
    for (const auto& column : data->columns) names.push_back(column.channel.name());
    return names;
  }

  const std::string plan = lines_of(3, {1, -1, 0.5}, true);
  Folder folder;
  SmallWorld world;
  TiltWorld tilts, second_tilts{.zero_arcsec = -7};
  CellInMemory cell;
};

class ConfirmedSetups : public Setups {
 protected:
  ConfirmedSetups() : Setups(true) {}
};

TEST_F(Setups, ReadTheInstrumentsThatTheyNameAndNoOthers) {
  tilts.away = true;  // the autocollimator stands in another room
  const auto lengths = measure_in("length", plan);
  EXPECT_EQ(lengths.state, RunState::done) << lengths.reason;
  EXPECT_EQ(lengths.given_up, 0);
  EXPECT_EQ(tilts.readings, 0);
  EXPECT_EQ(application::setup_of(lengths), "length");
  EXPECT_THAT(channels_of(lengths.id), Contains("x_mm"));
  EXPECT_THAT(channels_of(lengths.id), Not(Contains("ry_arcsec")));

  tilts.away = false;
  world.laser_away = true;
  const auto angles = measure_in("tilt", plan);
  EXPECT_EQ(angles.state, RunState::done) << angles.reason;
  EXPECT_THAT(channels_of(angles.id), Contains("ry_arcsec"));
  EXPECT_THAT(channels_of(angles.id), Not(Contains("x_mm")));
  EXPECT_THAT(channels_of(angles.id), Not(Contains("x_std_nm")));
}

TEST_F(ConfirmedSetups, KeepTheSecondReadingOfAConfirmedRotationAndItsDifference) {
  const auto run = measure_in("sure", plan);
  ASSERT_EQ(run.state, RunState::done) << run.reason;
  EXPECT_EQ(run.given_up, 0);
  const auto data = cell.await(cell.read([&run](Store& store) {
    return store.runs().dataset({&run.id, 1});
  }));
  const auto* first = data->find("ry");
  const auto* confirmed = data->find("ry_confirmed");
  const auto* difference = data->find("ry_difference");
  ASSERT_TRUE(first && confirmed && difference);
  // Each counts from its own zero at the datum: 3 and -7 arcsec of the devices are gone.
  for (std::size_t i = 0; i < data->rows; ++i) {
    EXPECT_NEAR(confirmed->values[i], first->values[i], 0.1);
    EXPECT_NEAR(difference->values[i], confirmed->values[i] - first->values[i], 1e-9);
  }
}

TEST_F(ConfirmedSetups, GiveUpARowWhoseRotationIsNotConfirmedAndTellBothFigures) {
  second_tilts.wrong_per_mm =
      1;  // 1 arcsec too much at 1 mm, 0.5 at 0.5 mm: beyond the limit of 0.5
  const auto run = measure_in("sure", "q1_mm,zero\n0,1\n1,0\n0.2,0\n0,1\n");
  ASSERT_EQ(run.state, RunState::done) << run.reason;
  EXPECT_EQ(run.given_up, 1);
  EXPECT_EQ(run.accepted, 3);
  const auto attempts = cell.await(cell.attempts(run.id));
  ASSERT_TRUE(attempts);
  const auto refused =
      std::ranges::find_if(*attempts, [](const auto& one) { return !one.reason.empty(); });
  ASSERT_NE(refused, attempts->end());
  EXPECT_EQ(refused->row, 1);
  EXPECT_THAT(refused->reason,
              testing::AllOf(HasSubstr("by 'tilts' and"), HasSubstr("by 'tilts-2': difference +"),
                             HasSubstr("arcsec, limit 0.5")));
}

TEST_F(ConfirmedSetups, NeedTheInstrumentThatConfirms) {
  second_tilts.away = true;
  const auto begun = try_in("sure", plan);
  ASSERT_TRUE(begun);
  cell.pass(600);
  EXPECT_NE(cell.await(cell.run(begun->id))->state, RunState::done);
  second_tilts.away = false;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(Setups, TheDatasetOfARunStatesWhichInstrumentsGaveItsCoordinates) {
  const auto stated = [this](RunId first, std::optional<RunId> second) {
    const auto data = cell.await(cell.read([first, second](Store& store) {
      std::vector<RunId> runs = {first};
      if (second) runs.push_back(*second);
      return application::amended_dataset(store, runs);
    }));
    if (!data) throw std::runtime_error(data.error().message);
    return measured_by_from(data->metadata);
  };
  const auto length = measure_in("length", plan), both = measure_in("both", plan);
  EXPECT_THAT(stated(length.id, {}), ElementsAre(MeasuredBy{"x", {{{"laser-x"}}}}));
  EXPECT_THAT(stated(both.id, {}),
              ElementsAre(MeasuredBy{"ry", {{{"tilts"}}}}, MeasuredBy{"x", {{{"laser-x"}}}}));
  EXPECT_THAT(stated(length.id, both.id), ElementsAre(MeasuredBy{"x", {{{"laser-x"}}}}))
      << "one of the two says nothing of the tilt";
}

TEST_F(Setups, AnInstrumentThatNobodyUsesAndThatDoesNotAnswerIsANoticeOfItsOwn) {
  tilts.away = true;
  ASSERT_TRUE(try_in("length", lines_of(12, {1, -1, 0.5}, true)));
  const auto of_tilts = [this] {
    std::vector<AlarmRecord> found;
    const auto alarms = cell.await(cell->alarms.list(true, 100));
    for (const auto& alarm : *alarms)
      if (alarm.subject == "tilts") found.push_back(alarm);
    return found;
  };
  cell.until([&] { return !of_tilts().empty(); });
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  const auto told = of_tilts();
  ASSERT_EQ(told.size(), 1u) << "one incident is one alarm";
  EXPECT_EQ(told[0].kind, "device.unused");
  EXPECT_EQ(told[0].level, AlarmLevel::notice);
  EXPECT_THAT(told[0].message, testing::HasSubstr("the set-up in use does not name it"));
}

TEST_F(Setups, RectifyWhatAnInstrumentReads) {
  const auto plain = measure_in("both", plan), rectified = measure_in("length", plan);
  const auto x_at_1mm = [this](RunId run) {
    const auto points = cell.await(cell.points(run, 0, 100));
    for (const auto& point : *points)
      if (point.commanded_mm.front() == 1)
        for (const auto& value : point.values)
          if (value.channel == "x_mm") return value.value;
    return kMissing;
  };
  EXPECT_NEAR(x_at_1mm(rectified.id) - x_at_1mm(plain.id), 0.0005, 0.0001);  // 500 um/m
}

TEST_F(Setups, TakeAnInstrumentBeyondItsRangeAsAStateAndNoFailure) {
  const auto run = measure_in("both", lines_of(3, {1, 3, -3, -1}, true));  // 63 arcsec at 3 mm
  EXPECT_EQ(run.state, RunState::done) << run.reason;
  EXPECT_EQ(run.given_up, 0);
  EXPECT_EQ(run.accepted, run.rows);
  const auto points = cell.await(cell.points(run.id, 0, 100));
  for (const auto& point : *points) {
    const bool has_tilt = std::ranges::any_of(
        point.values, [](const auto& value) { return value.channel == "ry_arcsec"; });
    EXPECT_EQ(has_tilt, std::abs(point.commanded_mm.front()) < 2) << "row " << point.row;
  }
}

TEST_F(Setups, ZeroAnInterferometerThatLostItsBeamOnTheWayAtTheNextReturn) {
  tilts.breaks_beam = true;
  const auto run = measure_in("near", lines_of(2, {1, 1.25, -1}, true));
  EXPECT_EQ(run.state, RunState::done) << run.reason;
  EXPECT_EQ(run.accepted, run.rows);
  EXPECT_GE(cell.await(cell.datums(run.id))->size(), 2u);  // the first, and one after a loss
  const auto points = cell.await(cell.points(run.id, 0, 100));
  for (const auto& point : *points) {
    const double q_mm = point.commanded_mm.front();
    const bool has_length = std::ranges::any_of(
        point.values, [](const auto& value) { return value.channel == "x_mm"; });
    EXPECT_EQ(has_length, q_mm == 0 || q_mm == 1) << "row " << point.row << " at " << q_mm;
  }
}

TEST_F(Setups, AreRefusedWhenTheCellDoesNotKnowThem) {
  const auto refused = try_in("tilts", plan);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "NO_SUCH_SETUP");
  EXPECT_THAT(refused.error().message,
              HasSubstr("found 'tilts', expected one of cell 'small': length, tilt, both, near"));
}

TEST(SetupOfARun, IsNeededWhereTwoInstrumentsGiveOneCoordinate) {
  CellDescription cell;
  cell.name = "small";
  for (const char* id : {"laser", "touch"}) {
    auto& device = cell.devices.emplace_back();
    device.id = id;
    device.become<LengthSettings>().channel = {"z", "mm"};
    auto& setup = cell.setups.emplace_back();
    setup.name = id;
    auto& coordinate = setup.coordinates.emplace_back();
    coordinate.channel = {"z", "mm"};
    coordinate.device = id;
  }
  EXPECT_TRUE(application::check_setup(cell, "touch"));
  const auto neither = application::check_setup(cell, "");
  ASSERT_FALSE(neither);
  EXPECT_EQ(neither.error().reason, "NO_SUCH_SETUP");
  EXPECT_THAT(neither.error().message,
              HasSubstr("expected one of cell 'small': laser, touch; z_mm is given by 'laser' "
                        "and by 'touch'"));
}

TEST_F(Setups, OfAQueuedCampaignAreThoseOfItsRun) {
  tilts.away = true;
  application::QueueDraft draft;
  draft.name = "night";
  draft.trajectory_name = "night.csv";
  draft.trajectory_text = plan;
  draft.setup = "nights";
  EXPECT_EQ(cell.await(cell->queue.add(cell.ada, draft)).error().reason, "NO_SUCH_SETUP");
  draft.setup = "length";
  const auto line = cell.await(cell->queue.add(cell.ada, draft));
  ASSERT_TRUE(line) << line.error().message;
  cell.until([&] { return cell->queue.get(line->entry.id)->entry.state == QueueState::done; });
  const auto run = *cell.await(cell.run(*cell->queue.get(line->entry.id)->entry.run));
  EXPECT_EQ(application::setup_of(run), "length");
  const auto rules = application::read_run_plan(run.rules_json)->rules;
  EXPECT_EQ(rules.settle_s, 1);  // the cell's, as nobody stated others
}

TEST_F(Setups, OfSeveralRunsJoinIntoOneDataset) {
  const auto lengths = measure_in("length", plan), angles = measure_in("tilt", plan);
  application::JoinRequest request{.runs = {lengths.id, angles.id}};
  const auto joined = cell.await(cell->datasets.join(cell.ada, request));
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_THAT(channels_of(joined->run->id), Contains("x_mm"));
  EXPECT_THAT(channels_of(joined->run->id), Contains("ry_arcsec"));
}

TEST_F(Setups, ARunWithoutOneNeedsEveryInstrument) {
  tilts.away = true;
  const auto begun = try_in("", plan);
  ASSERT_TRUE(begun);
  cell.pass(600);
  EXPECT_NE(cell.await(cell.run(begun->id))->state, RunState::done);
  tilts.away = false;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

}  // namespace
}  // namespace driftwise::tests
