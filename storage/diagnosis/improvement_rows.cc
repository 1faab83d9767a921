#include "storage/diagnosis/improvement_rows.h"

#include "server/core/reasons.h"
#include "storage/diagnosis/extension_rows.h"

namespace driftwise::storage {
namespace {

[[noreturn]] void throw_no_such_improvement(Session& session, ImprovementId id) {
  throw_failure(ErrorCode::not_found, reasons::kNoSuchImprovement,
                "there is no improvement " + std::to_string(id.value) + " in database " +
                    session.db.path() + ": 'driftwise improve list' shows those there are");
}

// Figures of a gain: three columns from this one on; none: U90 is null.
std::optional<ErrorFigures> read_figures(const Query& query, int column) {
  if (query.is_null(column)) return std::nullopt;
  ErrorFigures figures{.u90 = query.real(column), .a90 = query.real(column)};
  if (!query.is_null(column + 1)) figures.mean = query.real(column + 1);
  if (!query.is_null(column + 2)) figures.a90 = query.real(column + 2);
  return figures;
}

std::vector<TurnGain> read_gains(Session& session, ImprovementId id, int number) {
  Query query(session.db,
              "SELECT output, unit, u90_before, mean_before, a90_before, u90_predicted, "
              "mean_predicted, a90_predicted, u90_measured_before, mean_measured_before, "
              "a90_measured_before, u90_measured, mean_measured, a90_measured FROM "
              "improvement_gain WHERE improvement_id = ? AND number = ? ORDER BY position");
  query.bind(id, number);
  std::vector<TurnGain> gains;
  while (query.row())
    gains.push_back({query.text(0), query.text(1), read_figures(query, 2).value_or(ErrorFigures{}),
                     read_figures(query, 5), read_figures(query, 8), read_figures(query, 11)});
  return gains;
}

std::vector<ImprovementTurn> read_turns(Session& session, ImprovementId id) {
  Query query(session.db,
              "SELECT number, runs, model_id, diagnosis_id, what, started_ns, ended_ns FROM "
              "improvement_turn WHERE improvement_id = ? ORDER BY number");
  query.bind(id);
  std::vector<ImprovementTurn> turns;
  while (query.row()) {
    ImprovementTurn turn;
    turn.number = static_cast<int>(query.integer(0));
    for (const std::int64_t run : numbers_from(query.text(1))) turn.runs.push_back({run});
    if (const auto model = query.optional_integer(2)) turn.model = ModelId{*model};
    if (const auto diagnosis = query.optional_integer(3)) turn.diagnosis = DiagnosisId{*diagnosis};
    turn.what = query.text(4);
    turn.started.utc_ns = query.integer(5);
    turn.ended.utc_ns = query.integer(6);
    turns.push_back(std::move(turn));
  }
  for (auto& turn : turns) turn.gains = read_gains(session, id, turn.number);
  return turns;
}

// The columns of improvement in the order of the two SELECTs below.
ImprovementRecord improvement_from(const Query& row) {
  ImprovementRecord record;
  record.id = {row.integer(0)};
  record.state = job_state_from(row.text(1)).value_or(JobState::failed);
  record.reason = row.text(2);
  record.trajectory_name = row.text(3);
  record.trajectory_text = row.text(4);
  record.formula = row.text(5);
  record.max_turns = static_cast<int>(row.integer(6));
  record.budget_s = row.real(7);
  record.promotes = row.integer(8) != 0;
  record.request_id = row.text(9);
  record.created.utc_ns = row.integer(10);
  record.created_by = row.text(11);
  record.ended.utc_ns = row.integer(12);
  return record;
}

}  // namespace

ImprovementRecord insert_improvement(Session& session, const ImprovementRecord& wanted) {
  if (!wanted.request_id.empty()) {
    Query same(session.db,
               "SELECT improvement_id FROM improvement WHERE request_id = ? AND request_id <> ''");
    if (same.bind(wanted.request_id).row())
      return read_improvement(session, ImprovementId{same.integer(0)});
  }
  Query(session.db,
        "INSERT INTO improvement (state, reason, trajectory_name, trajectory_text, formula, "
        "max_turns, budget_s, promotes, request_id, created_ns, created_by, ended_ns) VALUES "
        "('running', '', ?, ?, ?, ?, ?, ?, ?, ?, ?, 0)")
      .bind(wanted.trajectory_name, wanted.trajectory_text, wanted.formula, wanted.max_turns,
            wanted.budget_s, wanted.promotes ? 1 : 0, wanted.request_id, wanted.created.utc_ns,
            wanted.created_by)
      .run();
  return read_improvement(session, ImprovementId{session.db.last_row_id()});
}

void put_turn_row(Session& session, ImprovementId id, const ImprovementTurn& turn) {
  std::vector<std::int64_t> runs;
  for (const RunId run : turn.runs) runs.push_back(run.value);
  Query(session.db,
        "INSERT INTO improvement_turn (improvement_id, number, runs, model_id, diagnosis_id, what, "
        "started_ns, ended_ns) VALUES (?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO UPDATE SET "
        "runs = excluded.runs, model_id = excluded.model_id, diagnosis_id = excluded.diagnosis_id, "
        "what = excluded.what, started_ns = excluded.started_ns, ended_ns = excluded.ended_ns")
      .bind(id, turn.number, numbers_text(runs), turn.model, turn.diagnosis, turn.what,
            turn.started.utc_ns, turn.ended.utc_ns)
      .run();
  Query(session.db, "DELETE FROM improvement_gain WHERE improvement_id = ? AND number = ?")
      .bind(id, turn.number)
      .run();
  int position = 0;
  const auto part = [](const std::optional<ErrorFigures>& of, double ErrorFigures::*figure) {
    return of ? std::optional((*of).*figure) : std::nullopt;
  };
  for (const auto& gain : turn.gains)
    Query(session.db,
          "INSERT INTO improvement_gain (improvement_id, number, position, output, unit, "
          "u90_before, mean_before, a90_before, u90_predicted, mean_predicted, a90_predicted, "
          "u90_measured_before, mean_measured_before, a90_measured_before, u90_measured, "
          "mean_measured, a90_measured) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
        .bind(id, turn.number, position++, gain.output, gain.unit, gain.before.u90,
              gain.before.mean, gain.before.a90, part(gain.predicted, &ErrorFigures::u90),
              part(gain.predicted, &ErrorFigures::mean), part(gain.predicted, &ErrorFigures::a90),
              part(gain.measured_before, &ErrorFigures::u90),
              part(gain.measured_before, &ErrorFigures::mean),
              part(gain.measured_before, &ErrorFigures::a90),
              part(gain.measured, &ErrorFigures::u90), part(gain.measured, &ErrorFigures::mean),
              part(gain.measured, &ErrorFigures::a90))
        .run();
}

void end_improvement_row(Session& session, ImprovementId id, JobState state,
                         const std::string& reason, CellTime at) {
  Query(session.db,
        "UPDATE improvement SET state = ?, reason = ?, ended_ns = ? WHERE improvement_id = ? AND "
        "state = 'running'")
      .bind(to_string(state), reason, at.utc_ns, id)
      .run();
  if (session.db.changed_rows() == 1) return;
  const auto stored = read_improvement(session, id);
  throw_failure(ErrorCode::failed_precondition, reasons::kAlreadyOver,
                "improvement " + std::to_string(id.value) + " is over: it is " +
                    std::string(to_string(stored.state)));
}

ImprovementRecord read_improvement(Session& session, ImprovementId id) {
  Query query(session.db,
              "SELECT improvement_id, state, reason, trajectory_name, trajectory_text, formula, "
              "max_turns, budget_s, promotes, request_id, created_ns, created_by, ended_ns FROM "
              "improvement WHERE improvement_id = ?");
  if (!query.bind(id).row()) throw_no_such_improvement(session, id);
  auto record = improvement_from(query);
  record.turns = read_turns(session, id);
  return record;
}

// Without the plans' texts: a list shows none of them, and 200 may have 8 MiB each.
std::vector<ImprovementRecord> read_improvements(Session& session, int limit) {
  Query query(session.db,
              "SELECT improvement_id, state, reason, trajectory_name, '', formula, "
              "max_turns, budget_s, promotes, request_id, created_ns, created_by, ended_ns FROM "
              "improvement ORDER BY improvement_id DESC LIMIT ?");
  query.bind(limit > 0 ? limit : -1);
  std::vector<ImprovementRecord> improvements;
  while (query.row()) improvements.push_back(improvement_from(query));
  for (auto& record : improvements) record.turns = read_turns(session, record.id);
  return improvements;
}

}  // namespace driftwise::storage
