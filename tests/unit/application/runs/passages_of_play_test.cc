// Play of a robot whose plan has no returns to zero, told by the way that it took: a run of the
// simulated linear axis, behind the ports.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "server/core/data/row_marks.h"
#include "server/diagnosis/diagnose.h"
#include "server/formats/formula/formula.h"
#include "tests/support/cell_in_memory.h"
#include "tests/support/plant_cell.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

constexpr int kLines = 24;
constexpr const char* kBaseline = "x ~ poly(q1, 3) + t07";

// Lines of four places of a seeded draw within 4 mm: about every other first row of a line is
// reached from one side over the zero, and from the other one straight from the row before.
std::string drawn_lines(bool with_zero) {
  std::string csv = "q1_mm,set,line,zero\n";
  std::uint32_t state = 12345;
  for (int line = 1; line <= kLines; ++line) {
    for (int i = 0; i < 4; ++i) {
      state = state * 1664525u + 1013904223u;  // Numerical Recipes, section 7.1
      const double q_mm = 8.0 * static_cast<double>(state >> 16) / 65536.0 - 4.0;
      csv += fmt::format("{:.4f},calibration,{},0\n", q_mm, line);
    }
    if (with_zero) csv += fmt::format("0,calibration,{},1\n", line);
  }
  return csv;
}

// Friction of 3 N at a joint of 10 N/um: 600 nm between the two sides.
Dataset measured(bool with_zero) {
  const Folder folder;
  PlantWorld world;
  world.plant = simulated::make_any_plant(
      DRIFTWISE_SOURCE_DIR "/deploy/cells/linear-axis/plant.toml",
      {.seed = 7,
       .overrides = {"hidden.h1={kind=\"friction\",axis=1,friction_n=3,stiffness_n_um=10,"
                     "presliding_um=1}"},
       .epoch_ns = kWorldBegin.utc_ns});
  world.plant->set_instants_per_reading(1);
  CellInMemory cell(
      [&world](VirtualTime& time, const CellDescription& described) {
        return plant_devices(world, time, described);
      },
      shipped_cell("linear-axis", folder / "cell.sqlite"), kSqlite, CellInMemory::Further{});
  cell.begin_run(drawn_lines(with_zero));
  const auto run = cell.finish_run();
  if (run.state != RunState::done) throw std::runtime_error(run.reason);
  return *cell.await(
      cell.read([&run](Store& store) { return store.runs().dataset(std::vector{run.id}); }));
}

double rmse_with_play_nm(const Dataset& data) {
  const auto model = formats::fit_formula(data, std::string(kBaseline) + " + play(q1, 600 nm)", {});
  if (!model) throw std::runtime_error(model.error().message);
  return 1e6 * model->outputs.front().accuracy.rmse;
}

std::vector<std::string> named(const Dataset& data) {
  diagnosis::DiagnoseOptions options;
  options.baseline = *formats::Formula::parse(kBaseline)->expand(data);
  const auto found = diagnosis::diagnose(data, options);
  if (!found) throw std::runtime_error(found.error().message);
  std::vector<std::string> names;
  for (const auto& finding : found->findings)
    names.push_back(finding.cause + " " + finding.subject);
  return names;
}

TEST(PassagesOfPlay, TellItByTheWayThatTheRobotTook) {
  const auto data = measured(false);
  EXPECT_EQ(std::ranges::count(data.excluded, kPassageRow), kLines + 3)
      << "the first datum, each line, and both ways to the one return that was doubted";
  EXPECT_THAT(named(data), testing::ElementsAre("backlash q1"));

  // As well as with the same returns in the plan; the rows alone are of another path.
  const auto planned = measured(true);
  EXPECT_THAT(named(planned), testing::ElementsAre("backlash q1"));
  EXPECT_NEAR(rmse_with_play_nm(data), rmse_with_play_nm(planned), 5);
  EXPECT_LT(rmse_with_play_nm(data), 51);
  auto rows_alone = data;
  leave_passages_out(rows_alone);
  EXPECT_GT(rmse_with_play_nm(rows_alone), 100);
  EXPECT_THAT(named(rows_alone), testing::Not(testing::Contains("backlash q1")));
}

// Without an effect of the path a fit is the same to the last bit, whatever lies between its rows.
TEST(PassagesOfPlay, ChangeNothingWithoutMemory) {
  const auto data = measured(false);
  auto rows_alone = data;
  leave_passages_out(rows_alone);
  const auto one = formats::fit_formula(data, kBaseline, {});
  const auto other = formats::fit_formula(rows_alone, kBaseline, {});
  ASSERT_TRUE(one && other);
  EXPECT_EQ(one->outputs.front().accuracy.rmse, other->outputs.front().accuracy.rmse);
  EXPECT_EQ(one->lineage.rows_calibration, other->lineage.rows_calibration);
  EXPECT_EQ(one->lineage.rows_excluded, 0) << "nobody kept a row out";
}

}  // namespace
}  // namespace driftwise::tests
