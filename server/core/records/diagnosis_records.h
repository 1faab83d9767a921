#pragma once
// What the store keeps of a diagnosis, of what was made of it, and of the loop that improves.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/data/accuracy.h"
#include "server/core/ids.h"
#include "server/core/records/configuration_records.h"
#include "server/core/records/records.h"

namespace driftwise {

enum class JobState : std::uint8_t { running, done, cancelled, failed };
std::string_view to_string(JobState state);
std::optional<JobState> job_state_from(std::string_view text);

struct DiagnosisRecord {
  DiagnosisId id;
  std::string name;
  JobState state = JobState::running;
  std::string reason;              // why it failed or was cancelled
  std::vector<RunId> runs;         // empty: a file
  std::optional<ModelId> model;    // the simulation it began from, when that was a model
  std::string baseline, extended;  // formulas
  std::string request_json;        // what was asked, for the record
  std::string result_json;         // the diagnosis whole; empty until it is done
  CellTime created, ended;         // utc_ns 0: not yet
  std::string created_by;
};

struct DiagnosisEnd {
  JobState state = JobState::done;
  std::string reason, extended, result_json;
  std::string rows;  // per row of its dataset, for plots; bytes that only their writer reads
  CellTime at;
};

// Something that fits see and the stored points do not: how an instrument was wrong, where a datum
// splits, which sensor lies. In force from created until ended.
struct CorrectionRecord {
  CorrectionId id;
  std::optional<DiagnosisId> diagnosis;
  std::string json;  // server/formats/correction_json.h
  CellTime created, ended;
  std::string created_by, ended_by;
  std::vector<LengthChange> changes{};  // of the runs there were when it was accepted
  bool in_force() const { return ended.utc_ns == 0; }
};

struct RowsOfRun {
  RunId run;
  std::vector<std::int64_t> rows;  // of the trajectory, ascending
};

struct ExtensionRecord {
  DiagnosisId diagnosis;
  std::vector<int> findings;     // numbers within the diagnosis, from 1
  std::optional<ModelId> model;  // that was made, and
  bool promoted = false;         // serves
  std::optional<CorrectionId> correction;
  std::vector<RowsOfRun>
      excluded;               // rows that it keeps out; what a person kept out before is not its
  CellTime accepted, undone;  // utc_ns 0: it stands
  std::string accepted_by, undone_by;
  bool stands() const { return undone.utc_ns == 0; }
};

struct NewExtension {
  DiagnosisId diagnosis;
  std::vector<int> findings;
  std::optional<ModelId> model;
  bool promoted = false;
  std::string correction_json;              // empty: no correction
  std::vector<LengthChange> changes{};      // of the correction
  std::vector<ExclusionRecord> exclusions;  // who and when are taken from here, below
  // The model that was fitted for it (then `model` is not looked at). Stored in the same
  // transaction. It rests on the corrections that it names, and on the one that is made here when
  // rests_on_this says so. With `promoted` its promotion is stored too.
  std::optional<ModelRecord> fitted{};
  bool rests_on_this = false;
  Stamp at;
  std::string who, from;
};

struct TurnGain {  // of one output; the numbers of rows are not kept
  std::string output, unit;
  ErrorFigures before;                    // on rows that the diagnosis held out
  std::optional<ErrorFigures> predicted;  // ... with its findings
  // On the fresh points, by the model before and by the model after: these two decide.
  std::optional<ErrorFigures> measured_before, measured;
};

struct ImprovementTurn {
  int number = 1;
  std::vector<RunId> runs;
  std::optional<ModelId> model;
  std::optional<DiagnosisId> diagnosis;
  std::string what;  // a sentence: what it did and found
  std::vector<TurnGain> gains;
  CellTime started, ended;
};

struct ImprovementRecord {
  ImprovementId id;
  JobState state = JobState::running;
  std::string reason;
  std::string trajectory_name, trajectory_text, formula;
  int max_turns = 5;
  double budget_s = 0;
  bool promotes = false;
  std::string request_id;
  CellTime created, ended;
  std::string created_by;
  std::vector<ImprovementTurn> turns;
};

}  // namespace driftwise
