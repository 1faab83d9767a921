// A model is served as it was stored, or not at all.

#include <gmock/gmock.h>

#include "server/application/queue/queue.h"
#include "server/compensation/target.h"
#include "server/formats/model/model_json.h"
#include "storage/sqlite/database.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class ModelDamage : public testing::Test {
 protected:
  Folder folder;
  const std::string path = folder / "cell.sqlite";
  SmallWorld world;
  std::optional<CellInMemory> cell{std::in_place, world, small_cell(path), kSqlite};

  ModelRecord fit(RunId run, const std::string& formula) {
    application::FitRequest fit;
    fit.runs = {run};
    fit.formula = formula;
    auto model = cell->await((*cell)->models.fit(cell->ada, fit));
    if (!model) throw std::runtime_error(model.error().message);
    return *model;
  }
  // Changes the database as a disk or a person might, while the daemon is away.
  void restart_after(const std::string& sql) {
    const auto later = cell->now() + std::chrono::hours(1);
    cell.reset();
    storage::Database(path, SQLITE_OPEN_READWRITE, "").execute(sql);
    cell.emplace(world, small_cell(path), kSqlite, later);
    cell->pass(10);
  }
  Error refusal() {
    const auto snapshot = (*cell)->targets.snapshots().read();
    compensation::TargetRequest request;
    request.set(compensation::Variable::x, 1.0);
    return compensation::refusal_error(*snapshot, compensation::compute_target(*snapshot, request));
  }
  std::vector<std::string> alarms(const std::string& kind) { return cell->alarms_of(kind); }
};

TEST_F(ModelDamage, AChangedCoefficientIsRefusedAndNoOtherModelTakesItsPlace) {
  const auto run = cell->begin_run(lines_of(6, {-4, -2, 1, 3, 4}, true));
  cell->finish_run();
  const auto first = fit(run.id, "q1 ~ x"), second = fit(run.id, "q1 ~ x + x^2");
  ASSERT_TRUE(cell->await((*cell)->promotions.promote(cell->ada, first.id, true)));
  ASSERT_TRUE(cell->await((*cell)->promotions.promote(cell->ada, second.id, true)));
  restart_after(
      "UPDATE model SET json = replace(json, '\"p_enter\":0.05', '\"p_enter\":0.06') "
      "WHERE model_id = " +
      std::to_string(second.id.value));
  EXPECT_FALSE(cell->status().serving) << "neither this one nor the one before";
  EXPECT_EQ(refusal().reason, "MODEL_DAMAGED");
  EXPECT_THAT(refusal().message, HasSubstr("model " + std::to_string(second.id.value)));
  EXPECT_THAT(alarms("model.damaged"), SizeIs(1));
  const auto models = *cell->await((*cell)->models.list());
  ASSERT_THAT(models, SizeIs(2));
  EXPECT_EQ(models[0].record.damage, "");
  EXPECT_THAT(models[1].record.damage, HasSubstr("hash"));
  EXPECT_EQ(cell->await((*cell)->models.get(second.id)).error().reason, "MODEL_DAMAGED");
  EXPECT_EQ(cell->await((*cell)->promotions.promote(cell->ada, second.id, true)).error().reason,
            "MODEL_DAMAGED");
  // A person chooses another one.
  ASSERT_TRUE(cell->await((*cell)->promotions.promote(cell->ada, first.id, true)));
  EXPECT_EQ(cell->status().serving, first.id);
  EXPECT_EQ(refusal().reason, "NOT_REFUSED");
  cell->pass(30);
  EXPECT_THAT(alarms("model.damaged"), IsEmpty());
}

TEST_F(ModelDamage, ATextThatIsNoModelAnyMoreIsRefusedToo) {
  const auto run = cell->begin_run(lines_of(6, {-4, -2, 1, 3, 4}, true));
  cell->finish_run();
  const auto model = fit(run.id, "q1 ~ x");
  ASSERT_TRUE(cell->await((*cell)->promotions.promote(cell->ada, model.id, true)));
  restart_after("UPDATE model SET json = substr(json, 1, 100)");
  EXPECT_EQ(refusal().reason, "MODEL_DAMAGED");
  EXPECT_THAT(*cell->await((*cell)->models.list()), SizeIs(1));
}

// As a version before the refusal promoted it.
TEST_F(ModelDamage, AModelThatThisVersionCannotServeIsRefusedWithItsReason) {
  const auto run = cell->begin_run(lines_of(6, {-4, -2, 1, 3, 4}, true));
  cell->finish_run();
  application::FitRequest request;
  request.runs = {run.id};
  request.formula = "q1 ~ x + drift()";
  request.select = "all";
  const auto model = cell->await((*cell)->models.fit(cell->ada, request));
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(cell->await((*cell)->promotions.promote(cell->ada, model->id, true)).error().reason,
            "TERM_NOT_SERVABLE");
  restart_after("INSERT INTO promotion (model_id, at_ns, by_whom, action) VALUES (" +
                std::to_string(model->id.value) + ", 1, 'ada', 'promote')");
  EXPECT_EQ(refusal().reason, "TERM_NOT_SERVABLE");
  EXPECT_THAT(cell->events_named("serving.refused"), SizeIs(1));
}

TEST_F(ModelDamage, AnUndamagedModelServesAgainAfterARestart) {
  const auto run = cell->begin_run(lines_of(6, {-4, -2, 1, 3, 4}, true));
  cell->finish_run();
  const auto model = fit(run.id, "q1 ~ x + t01");
  EXPECT_EQ(formats::stored_model_hash(model.json).value_or(""), model.hash);
  ASSERT_TRUE(cell->await((*cell)->promotions.promote(cell->ada, model.id, true)));
  restart_after("SELECT 1 WHERE 0");
  EXPECT_EQ(cell->status().serving, model.id);
}

// A run of the queue that moves by a model, interrupted by the end of the daemon.
class RunByDamagedModel : public ModelDamage {
 protected:
  void interrupt() {
    const auto first = cell->begin_run(lines_of(6, {-4, -2, 1, 3, 4}, true));
    cell->finish_run();
    application::QueueDraft draft;
    draft.name = "night";
    draft.trajectory_name = "night.csv";
    draft.trajectory_text = "x_mm\n1\n2\n-1\n-2\n3\n1\n2\n-1\n-2\n3\n";
    draft.compensate = true;
    draft.compensate_with = fit(first.id, "q1 ~ x").id;
    ASSERT_TRUE((*cell)->manual.give_up_lease(cell->ada, cell->lease()));
    entry = cell->await((*cell)->queue.add(cell->ada, draft))->entry.id;
    cell->until([&] {
      return cell->status().run && cell->status().run->run.id == run &&
             cell->status().run->run.accepted == 3;
    });
    restart_after(kDamage);
  }
  RunRecord now() { return *cell->await((*cell)->runs.get(run)); }

  const RunId run{2};
  QueueEntryId entry;
  const std::string kDamage =
      "UPDATE model SET json = replace(json, '\"p_enter\":0.05', '\"p_enter\":0.06')";
  const std::string kMended =
      "UPDATE model SET json = replace(json, '\"p_enter\":0.06', '\"p_enter\":0.05')";
};

TEST_F(RunByDamagedModel, StandsWithTheReasonAndCanBeAborted) {
  interrupt();
  ASSERT_TRUE(cell->status().run);
  EXPECT_EQ(now().state, RunState::waiting);
  EXPECT_EQ(now().hold.kind, RunHold::Kind::trouble);
  EXPECT_THAT(now().reason, HasSubstr("run 2 cannot be continued: model 1"));
  const int moves = world.moves;
  cell->pass(600);
  EXPECT_EQ(world.moves, moves);
  EXPECT_THAT(alarms("run.waiting"), SizeIs(1));
  const auto aborted = cell->await((*cell)->runs.abort(cell->ada, run, ""));
  ASSERT_TRUE(aborted) << aborted.error().message;
  cell->pass(10);
  EXPECT_EQ(now().state, RunState::aborted);
  EXPECT_EQ(now().accepted, 3);
  EXPECT_EQ((*cell)->queue.get(entry)->entry.state, QueueState::waiting) << "back in the queue";
}

TEST_F(RunByDamagedModel, GoesOnWhenThatIsMendedAndAPersonResumesIt) {
  interrupt();
  const auto in_vain = cell->resume();
  ASSERT_TRUE(in_vain) << in_vain.error().message;
  cell->pass(10);
  EXPECT_EQ(now().state, RunState::waiting) << "it is read again, and still damaged";
  EXPECT_EQ(now().hold.kind, RunHold::Kind::trouble);
  storage::Database(path, SQLITE_OPEN_READWRITE, "").execute(kMended);
  ASSERT_TRUE(cell->resume());
  const auto ended = cell->finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  EXPECT_EQ(ended.id, run);
  EXPECT_EQ(ended.accepted, 10);
}

TEST_F(RunByDamagedModel, GoesOnByItselfWithTheNextStartAfterThatIsMended) {
  interrupt();
  cell->pass(600);
  restart_after(kMended);
  const auto ended = cell->finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  EXPECT_EQ(ended.accepted, 10);
  const auto attempts = *cell->await(cell->attempts(run));
  for (const auto& attempt : attempts)
    EXPECT_NE(attempt.reason.substr(0, 16), "the daemon ended") << "it ended in good order";
}

TEST_F(RunByDamagedModel, KeepsAPauseOfAPersonOverTheNextStart) {
  interrupt();
  ASSERT_TRUE(cell->await((*cell)->runs.pause(cell->ada, run)));
  cell->pass(10);
  EXPECT_EQ(now().state, RunState::paused);
  restart_after(kMended);
  cell->pass(600);
  EXPECT_EQ(now().state, RunState::paused);
  EXPECT_EQ(now().hold.who, "ada");
  ASSERT_TRUE(cell->resume());
  EXPECT_EQ(cell->finish_run().state, RunState::done);
}

}  // namespace
}  // namespace driftwise::tests
