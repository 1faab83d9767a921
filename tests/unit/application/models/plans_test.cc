// A serving plan on a cell: kept, promoted, asked, and serving again after a restart.

#include "server/application/plans/plans.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "server/application/models/models.h"
#include "server/application/plans/joint_targets.h"
#include "server/plans/joint_target.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using compensation::Variable;

class PlansOnACell : public testing::Test {
 protected:
  PlansOnACell() { restart(); }
  void restart() {
    cell.reset();
    cell.emplace(world, small_cell(folder / "cell.sqlite"), kSqlite, kWorldBegin + starts++ * kDay);
  }
  std::int64_t fitted(const std::string& csv, const std::string& formula) {
    application::FitRequest request;
    request.csv = csv;
    request.formula = formula;
    const auto model = cell->await((*cell)->models.fit(cell->ada, std::move(request)));
    if (!model) throw std::runtime_error(model.error().message);
    return model->id.value;
  }
  // ma moves sideways by 1 um per mm of its height.
  std::string a_plan() {
    std::string mn = "mn.q1_mm,mn.x_mm,mn.z_mm\n", ma = "ma.q1_mm,ma.z_mm,ma.x_mm\n";
    for (int i = 0; i < 40; ++i) {
      const double a = i % 8 - 3.5, b = i / 8 - 2, noise = 1e-6 * ((i * 7919) % 13 - 6);
      mn += fmt::format("{},{},{}\n", a + 0.1 * b + noise, a, b);
      ma += fmt::format("{},{},{}\n", a - noise, a, 1e-3 * a + noise);
    }
    return fmt::format(
        "name = \"joint\"\n[[robot]]\nid = \"mn\"\nmodel = {}\n[[robot]]\nid = \"ma\"\nmodel = {}\n"
        "[[parasitic]]\nmodel = {}\nfrom = \"ma\"\nto = \"mn\"\nadd = [\"x_mm\"]\n"
        "[z]\ntaken_by = \"mn\"\n",
        fitted(mn, "mn.q1 ~ mn.x + mn.z"), fitted(ma, "ma.q1 ~ ma.z"), fitted(ma, "ma.x ~ ma.z"));
  }
  // At mn.x = 1, z = 0, with ma at 2 mm.
  Result<double> asked() {
    const auto snapshot = (*cell)->joint_targets.board().read();
    if (!snapshot) return fail(ErrorCode::failed_precondition, "NOTHING_THERE", "no snapshot");
    plans::JointRequest request;
    request.now = cell->now();
    for (const auto& [name, value] :
         {std::pair{"mn.x_mm", 1.0}, std::pair{"z_mm", 0.0}, std::pair{"ma.z_mm", 2.0}})
      if (const auto place = plans::joint_name(*snapshot, name))
        request.set(place->robot, place->variable, value);
    const auto target = plans::compute_joint_target(*snapshot, request);
    if (target.refusal != compensation::Refusal::none)
      return tl::unexpected(plans::joint_refusal_error(*snapshot, target));
    return target.q_mm[0];
  }
  static constexpr Nanoseconds kDay = std::chrono::hours(24);
  Folder folder;
  SmallWorld world;
  int starts = 0;
  std::optional<CellInMemory> cell;
};

TEST_F(PlansOnACell, ServeOncePromotedAndAgainAfterARestart) {
  const auto text = a_plan();
  const auto plan = cell->await((*cell)->plans.add(cell->ada, text, "first", "7d0f"));
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->version, 1);
  const auto asked_first = cell->await((*cell)->plans.promote(cell->ada, plan->id, false));
  ASSERT_FALSE(asked_first);
  EXPECT_EQ(asked_first.error().reason, "NEEDS_CONFIRMATION");
  for (const char* model : {"(model 1) ", "(model 2) ", "(model 3) "})
    EXPECT_THAT(asked_first.error().message, testing::HasSubstr(model)) << "of a file";
  const auto promoted = cell->await((*cell)->plans.promote(cell->ada, plan->id, true));
  ASSERT_TRUE(promoted) << promoted.error().message;
  const auto q = asked();
  ASSERT_TRUE(q) << q.error().message;
  EXPECT_NEAR(*q, 1 + 2e-3, 1e-5);
  restart();
  cell->until([&] { return asked().has_value(); }, 60);
  EXPECT_NEAR(*asked(), *q, 1e-12);
  const auto list = cell->await((*cell)->plans.list());
  ASSERT_TRUE(list);
  EXPECT_EQ(list->serving, plan->id);
  const auto back = cell->await((*cell)->plans.roll_back(cell->ada));
  ASSERT_TRUE(back);
  EXPECT_FALSE(*back);
  EXPECT_EQ(asked().error().reason, "NO_PLAN");
}

TEST_F(PlansOnACell, AreRefusedWithEverythingThatStandsAgainstThem) {
  auto text = a_plan();
  text.replace(text.find("[z]"), std::string::npos, "");
  const auto plan = cell->await((*cell)->plans.add(cell->ada, text, "", ""));
  ASSERT_TRUE(plan) << plan.error().message;
  const auto promoted = cell->await((*cell)->plans.promote(cell->ada, plan->id, true));
  ASSERT_FALSE(promoted);
  EXPECT_EQ(promoted.error().reason, "AMBIGUOUS_COORDINATE");
  EXPECT_EQ(cell->await((*cell)->plans.add(cell->ada, text, "", ""))->id, plan->id);
}

}  // namespace
}  // namespace driftwise::tests
