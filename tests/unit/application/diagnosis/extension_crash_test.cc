// Kill -9 around the one transaction of an acceptance and of its undoing: all of it is there, or
// nothing.

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "server/application/plumbing/crash_point.h"
#include "storage/sqlite_store.h"
#include "tests/unit/application/diagnosis/diagnosed_cell.h"

namespace driftwise::tests {
namespace {

using effects::AppliesTo;

std::string campaign_csv() {
  std::string csv = "time_s,set,q1_mm,x_mm,t01_degC\n";
  for (int row = 0; row < 120; ++row) {
    const double x_mm = -4 + 8.0 * ((row * 89) % 120) / 120.0;
    char line[200];
    std::snprintf(line, sizeof line, "%d,%s,%.9f,%.9f,%.6f\n", 20 * row,
                  row % 4 == 3 ? "validation" : "calibration",
                  1.0002 * x_mm + 1e-6 * std::sin(row * 1.7), x_mm, 20.5 + 0.001 * row);
    csv += line;
  }
  return csv;
}

struct Kept {
  std::size_t models = 0, promotions = 0, corrections_in_force = 0, excluded = 0;
  bool accepted = false;
  std::optional<ModelId> serves;
  bool operator==(const Kept&) const = default;
};

Kept look(const std::string& database) {
  auto store = *storage::open_sqlite_store(database, true);
  Kept kept;
  const auto models = *store->models().models();
  kept.models = models.size();
  const auto promotions = *store->models().promotions();
  kept.promotions = promotions.size();
  if (!promotions.empty()) kept.serves = promotions.back().model;
  const auto corrections = *store->extensions().corrections();
  for (const auto& one : corrections) kept.corrections_in_force += one.in_force();
  const auto rows = *store->remarks().exclusions(RunId{1});
  for (const auto& one : rows) kept.excluded += one.excluded ? one.rows.size() : 0;
  if (const auto extension = *store->extensions().extension(DiagnosisId{1}))
    kept.accepted = extension->stands();
  return kept;
}

// In a child that dies at this crash point, of the acceptance or of its undoing.
void die_at(const std::string& database, const std::string& point) {
  const pid_t child = ::fork();
  if (child == 0) {
    application::on_crash_point([&point](std::string_view name) {
      if (name == point) ::raise(SIGKILL);
    });
    SmallWorld world;
    auto wave =
        finding_of("cyclic_error", "x", AppliesTo::correction, {"sin(x, 93000 nm)"}, {-4e-5});
    auto wrong = finding_of("outliers", "", AppliesTo::dataset, {}, {});
    wrong.rows = {7};
    CellInMemory cell(
        world, small_cell(database), kSqlite,
        {.diagnose = [&](const Dataset&,
                         const dx::DiagnoseOptions& options) -> Result<dx::Diagnosis> {
          return diagnosis_with(options.baseline.formula, {wave, wrong});
        }});
    if (!cell.await(cell->datasets.import_csv(cell.ada, "campaign", campaign_csv(), "")))
      ::_exit(3);
    application::DiagnosisRequest request;
    request.runs = {RunId{1}};
    request.baseline = "q ~ x";
    if (!cell.await(cell->diagnoses.create(cell.ada, request))) ::_exit(4);
    cell.until(
        [&] { return cell.await(cell->diagnoses.get({1}))->record.state == JobState::done; });
    if (!cell.await(cell->extensions.accept(cell.ada, {DiagnosisId{1}, {}, true, true})))
      ::_exit(5);
    static_cast<void>(cell.await(cell->extensions.undo(cell.ada, DiagnosisId{1})));
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << point << " was not passed, exit " << WEXITSTATUS(status);
}

TEST(AcceptCrash, BeforeTheCommitNothingIsThere) {
  Folder folder;
  die_at(folder / "cell.sqlite", "before_extension_commit");
  EXPECT_EQ(look(folder / "cell.sqlite"), Kept{});
}

TEST(AcceptCrash, AfterItAllOfItIs) {
  Folder folder;
  die_at(folder / "cell.sqlite", "after_extension_commit");
  const Kept all{1, 1, 1, 1, true, ModelId{1}};
  EXPECT_EQ(look(folder / "cell.sqlite"), all);
  // And the model that the record says serves does, after the start.
  SmallWorld world;
  CellInMemory cell(world, small_cell(folder / "cell.sqlite"), kSqlite,
                    kWorldBegin + std::chrono::hours(1));
  cell.pass(10);
  EXPECT_EQ(cell.status().serving, ModelId{1});
}

TEST(AcceptCrash, UndoneIsUndoneWhole) {
  Folder before, after;
  die_at(before / "cell.sqlite", "before_undo_commit");
  const Kept all{1, 1, 1, 1, true, ModelId{1}};
  EXPECT_EQ(look(before / "cell.sqlite"), all);
  die_at(after / "cell.sqlite", "after_undo_commit");
  const auto undone = look(after / "cell.sqlite");
  EXPECT_FALSE(undone.accepted);
  EXPECT_EQ(undone.corrections_in_force, 0u);
  EXPECT_FALSE(undone.serves) << "the promotion went back in the same transaction";
}

}  // namespace
}  // namespace driftwise::tests
