// Runs of one trajectory joined into one dataset of the record.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "server/formats/csv/dataset_csv.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

class JoinedRuns : public testing::Test {
 protected:
  RunId measure(const std::string& trajectory) {
    const auto begun = cell.begin_run(trajectory);
    cell.finish_run();
    return begun.id;
  }
  Result<application::JoinAnswer> join(application::JoinRequest request) {
    return cell.await(cell->datasets.join(cell.ada, std::move(request)));
  }
  int runs_in_all() { return static_cast<int>(cell.await(cell.runs(50, 0))->size()); }

  const std::string plan = lines_of(6, {2, -3, 1, -1}, true);
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};
};

TEST_F(JoinedRuns, BecomeARunThatFitsLikeAnyOther) {
  const RunId first = measure(plan), second = measure(plan);
  const auto joined = join({.runs = {first, second}});
  ASSERT_TRUE(joined) << joined.error().message;
  ASSERT_TRUE(joined->run);
  EXPECT_EQ(joined->run->name, "join of runs 1, 2");
  EXPECT_EQ(joined->run->state, RunState::done);
  EXPECT_EQ(joined->run->metadata, (RunMetadata{{"joined", "1, 2"}}));
  EXPECT_THAT(cell.events_named("data.joined"),
              ElementsAre(HasSubstr("ada joined runs 1, 2 as 'join of runs 1, 2'")));

  const auto report = nlohmann::json::parse(joined->report_json);
  const auto& channels = report.at("channels");
  const auto x =
      std::ranges::find_if(channels, [](const auto& c) { return c["channel"] == "x_mm"; });
  ASSERT_NE(x, channels.end());
  EXPECT_THAT((*x)["sources"], ElementsAre("run 1", "run 2"));
  EXPECT_LT((*x)["u_nm"].get<double>(), 60);  // 8 nm of holding, 1.5 nm of noise, a warming robot
  EXPECT_EQ(report["rows"], joined->run->rows);

  const auto csv = cell.await(cell->datasets.export_csv({joined->run->id}, false));
  ASSERT_TRUE(csv);
  EXPECT_THAT(*csv, HasSubstr("# joined: run 1 (sha256 "));
  EXPECT_THAT(*csv, HasSubstr("# join_x_mm: mean of run 1, run 2; u "));
  application::FitRequest fit;
  fit.runs = {joined->run->id};
  fit.formula = "q ~ x";
  EXPECT_TRUE(cell.await(cell->models.fit(cell.ada, fit)));
}

TEST_F(JoinedRuns, AreTheMeanRowByRow) {
  const RunId first = measure(plan), second = measure(plan);
  const auto joined = join({.runs = {first, second}});
  ASSERT_TRUE(joined) << joined.error().message;
  const auto data = [&](RunId run) {
    return *cell.await(cell.read([run](Store& store) { return store.runs().dataset({&run, 1}); }));
  };
  const auto a = data(first), b = data(second), both = data(joined->run->id);
  ASSERT_EQ(both.rows, a.rows);
  for (std::size_t row = 0; row < both.rows; ++row)
    EXPECT_DOUBLE_EQ(both.find("q1")->values[row],
                     (a.find("q1")->values[row] + b.find("q1")->values[row]) / 2);
}

TEST_F(JoinedRuns, HaveTheTimesAndTheNamesOfSetsOfTheFirst) {
  const std::string named = std::regex_replace(plan, std::regex("validation"), "inside");
  const RunId first = measure(named), second = measure(named);
  const auto joined = join({.runs = {first, second}});
  ASSERT_TRUE(joined) << joined.error().message;
  const auto lines_with = [&](RunId run, const std::string& word) {
    std::istringstream csv(*cell.await(cell->datasets.export_csv({run}, false)));
    std::vector<std::string> found;
    for (std::string line; std::getline(csv, line);)
      if (line.find(word) != std::string::npos) found.push_back(line);
    return found;
  };
  EXPECT_THAT(lines_with(joined->run->id, "# time_zero: "), SizeIs(1));
  EXPECT_EQ(lines_with(joined->run->id, "# time_zero: "), lines_with(first, "# time_zero: "));
  EXPECT_THAT(lines_with(joined->run->id, ",inside,"), SizeIs(12));
  EXPECT_EQ(cell.await(cell->datasets.set_names({joined->run->id}, ""))->size(),
            static_cast<std::size_t>(joined->run->rows));
}

TEST_F(JoinedRuns, OfADryRunAreNotStored) {
  const RunId first = measure(plan), second = measure(plan);
  const auto joined = join({.runs = {first, second}, .dry_run = true});
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_FALSE(joined->run);
  EXPECT_EQ(runs_in_all(), 2);
}

TEST_F(JoinedRuns, OfOneRequestAreOneRun) {
  const RunId first = measure(plan), second = measure(plan);
  application::JoinRequest request{.runs = {first, second}};
  request.request_id = "7d0f";
  const auto once = join(request);
  cell.pass(5);
  const auto twice = join(request);
  ASSERT_TRUE(once && twice);
  EXPECT_EQ(once->run->id, twice->run->id);
  EXPECT_EQ(cell.events_named("data.joined").size(), 1u);
}

TEST_F(JoinedRuns, AreRefusedWhereTrajectoriesDiffer) {
  const RunId first = measure(plan), other = measure(lines_of(6, {2, -3, 1, -2}, true));
  const auto refused = join({.runs = {first, other}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "TRAJECTORIES_DIFFER");
  EXPECT_THAT(refused.error().message, HasSubstr(": q1_mm is -1 in run 1 and -2 in run 2"));
  EXPECT_EQ(runs_in_all(), 2);
}

TEST_F(JoinedRuns, AreRefusedFromDatumsAtOtherTemperatures) {
  world.warming_k_per_h = 2;
  const RunId first = measure(plan);
  cell.pass(3600);
  const RunId second = measure(plan);
  const auto refused = join({.runs = {first, second}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "TEMPERATURES_DIFFER");
  EXPECT_THAT(refused.error().message, HasSubstr("at the datum of run 1"));
}

TEST_F(JoinedRuns, AreOfRunsThatAreOver) {
  const RunId first = measure(plan);
  const RunId under_way = cell.begin_run(plan).id;
  EXPECT_EQ(join({.runs = {first, under_way}}).error().reason, "RUN_UNDER_WAY");
  EXPECT_EQ(join({.runs = {first}}).error().reason, "NOTHING_TO_JOIN");
  EXPECT_EQ(join({.runs = {first, RunId{9}}}).error().reason, "NO_SUCH_RUN");
}

}  // namespace
}  // namespace driftwise::tests
