#pragma once
// The daemon as one object: what clients can ask of a cell. rpc/ and web/ translate and call;
// nothing else.
//
// Thread: everything on the executor's thread (co_spawn onto executor()), except snapshots() and
// now(), which any thread may read. Lifetime: start() once, then shut_down() once; the destructor
// expects the executor to have stopped. Whatever changes something takes a Caller and leaves an
// event.

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/database_health.h"
#include "server/application/ports/diagnosis_request.h"
#include "server/application/ports/run_hold.h"
#include "server/application/ports/watching.h"
#include "server/calibration/model/model.h"
#include "server/calibration/offer.h"
#include "server/compensation/snapshot_board.h"
#include "server/core/data/dataset.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/clock.h"
#include "server/core/ports/made_device.h"
#include "server/core/ports/store.h"
#include "server/core/records/stop_record.h"
#include "server/diagnosis/check_standard.h"
#include "server/diagnosis/verification.h"
#include "server/formats/diagnosis/stored_diagnosis.h"

namespace driftwise::application {

struct Caller {
  std::string name, peer;
};  // "ada", "ipv4:127.0.0.1:5020": as stated, unverified until roles exist

// The cell's devices, each behind the port of its role; made by main.
using Devices = std::vector<MadeDevice>;

struct LatestValue {
  Channel channel;
  double value = kMissing;
  CellTime at;
  double age_s = 0;
  bool stale = true;
  std::string device;
};
struct DeviceStatus {
  DeviceDescription description;
  DeviceHealth health;
};
struct Lease {
  std::string token, holder, peer;
  CellTime until;
};

// What became of a stop within the time of its answer.
struct StopAnswer {
  bool confirmed = false;           // every controller has reported no motion twice in succession
  std::string message;              // a sentence; not confirmed: "... use the emergency switch ..."
  std::vector<StopRecord> pending;  // by controller: those that have not confirmed
};

struct RunProgress {  // one line of a watch
  RunRecord run;
  std::string phase;  // "checking", "homing", "moving", "settling", "reading", "waiting for the
                      // stabiliser", ...
  std::int64_t row = 0, line = 0;
  double last_spread_nm = kMissing, last_closure_nm = kMissing;
  CellTime estimated_end;     // utc_ns 0: unknown
  double remaining_s = 0;     // of measuring, cell time: what a run that waits has still ahead
  std::int64_t sequence = 0;  // grows with every change
};

struct CellStatus {
  std::string name, version, config_hash, web_address;
  Stamp now;
  Nanoseconds utc_offset{0};  // UTC minus cell time, now
  double speed = 1;
  std::vector<DeviceStatus> devices;
  std::vector<LatestValue> values;
  std::optional<RunProgress> run;  // the one under way
  std::optional<Lease> lease;      // its token blanked
  std::optional<ModelId> serving;
  DatabaseHealth database;
  std::vector<std::string> attention;              // sentences: what a person should look at
  double longest_pause_s = 0, recent_pause_s = 0;  // of the executor (pause_meter.h)
  std::vector<StopRecord> pending_stops;  // by controller; while there is one nothing may move
};

struct CreateRun {
  std::string name, trajectory_name, trajectory_text, request_id;
  std::string lease_token;
  std::optional<RunRules> rules;
  bool compensate = false;                 // x_mm trajectories: move to the serving model's targets
  std::optional<ModelId> compensate_with;  // this model instead of the serving one
};

struct TrajectoryCheck {
  Trajectory trajectory;
  std::int64_t calibration = 0, validation = 0, zeros = 0, lines = 0;
  double estimated_s = 0;             // cell seconds
  std::vector<std::string> warnings;  // problems are errors: the check fails
};

struct FitRequest {
  std::vector<RunId> runs;
  std::string csv;  // instead of runs: a dataset as text
  std::string formula;
  std::string select = "stepwise";
  double p_enter = 0.05, p_remove = 0.10;
  std::string name, note;
  std::vector<std::string> exclude_channels;  // "t01": candidates left out
  std::int64_t first_rows = 0;                // fit only the first n rows; 0: all
  // As calibration::FitOptions and the command line have them.
  std::string criterion = "p";
  bool hierarchy = false;
  int starts = 1;
  std::int64_t seed = 1;
  std::vector<std::string> force_terms, without_terms;  // as a formula writes them
  std::optional<ModelId> parent;                        // for the lineage
  std::string weight_symbol;
  int blocks = 10;
  int threads = 0;  // at most; 0: one, beside the cell's own work. The model is the same
};

struct ModelCheck {  // does the robot still do what a model says? server/diagnosis/check_standard.h
  ModelId model;
  std::vector<RunRecord> runs;  // those looked at, in order of time
  diagnosis::CheckReport report;
};

// What a formula offers on some data, without fitting it: formula_check.h.
struct FormulaCheck {
  std::string problem;                        // with the place marked; empty: it can be fitted
  std::optional<std::size_t> problem_offset;  // bytes into the formula, where the text is at fault
  std::string canonical;
  std::vector<std::string> outputs, terms;  // symbols; notation, without the constant
  std::int64_t calibration = 0, validation = 0, dropped = 0;  // rows
  int rank = 0, columns = 0;
  std::vector<std::string> look_alikes;  // sentences
  std::vector<Channel> channels;         // of the data
};

// What a model leaves unexplained on the rows of a dataset.
struct ModelResiduals {
  struct Output {
    Channel channel;               // q1_mm
    std::vector<double> values;    // measured minus model, summary unit; NaN: cannot be said
    std::vector<double> held_out;  // as OutputModel::held_out, summary unit; empty: other rows
  };
  Dataset data;
  std::vector<Output> outputs;
  std::string dataset_hash;
  bool same_rows = false;  // the very dataset that the model was fitted to
};

// Which rows of a run are kept out of fits, and how it came to that.
struct ExclusionState {
  RunId run;
  std::vector<std::int64_t> rows;          // out now, ascending
  std::vector<std::int64_t> suspect_rows;  // those of them that the daemon marked as suspect
  std::string hash;                      // of the run's dataset, as in Lineage; empty: none is out
  std::vector<ExclusionRecord> history;  // oldest first
};

class Studies;
class Provenance;

class Cell {
 public:
  struct Parts {
    CellDescription description;
    Devices devices;
    std::unique_ptr<Clock> clock;
    OpenStore open_store;
    std::string version;
    // Where the writing store, the queries, the fits and the diagnoses run: at most one thread each
    // at a time. Empty: threads of the cell's own. A test hands in its one executor and has
    // everything in order.
    asio::any_io_executor storage_thread = {}, query_thread = {}, worker_thread = {},
                          diagnosis_thread = {}, text_thread = {}, upkeep_thread = {};
    std::string boot_id = {};      // of this start of the computer; empty: not known
    std::string web_address = {};  // "http://127.0.0.1:8080/", told in status(); empty: no web door
    Diagnose diagnose = {};        // empty: diagnosis::diagnose
    bool measure_pauses = false;   // of the executor: by the wall clock, so not in virtual time
  };
  static Result<std::unique_ptr<Cell>> open(asio::any_io_executor executor, Parts parts);
  virtual ~Cell() = default;

  virtual asio::any_io_executor executor() const = 0;
  // A thread beside the executor for what takes longer than a moment: texts that are read or
  // written, figures. Nothing there may touch the cell.
  virtual asio::any_io_executor background() const = 0;
  virtual CellTime now()
      const = 0;  // any thread, as snapshots(): a target's age is looked at where it is answered
  // UTC of an instant of cell time, and back; any thread.
  virtual UtcTime utc(CellTime instant) const { return {instant.utc_ns}; }
  virtual CellTime cell_time(UtcTime utc) const { return {utc.ns}; }
  // Starts the recorder and, where a run was under way when the daemon ended, its continuation.
  virtual void start() = 0;
  // Resumes when every device has been tried once, and status() says which are there.
  virtual Awaitable<void> devices_looked_at() = 0;
  virtual Awaitable<void> shut_down() = 0;

  virtual CellStatus status() const = 0;
  virtual const CellDescription& description() const = 0;

  virtual Result<Lease> take_lease(const Caller& caller, Nanoseconds duration,
                                   const std::string& token /* renews */) = 0;
  virtual Result<void> give_up_lease(const Caller& caller, const std::string& token) = 0;

  // Worked out in the background.
  virtual Awaitable<Result<TrajectoryCheck>> check_trajectory(std::string text) = 0;
  virtual Awaitable<Result<RunRecord>> create_run(Caller caller, CreateRun request) = 0;
  virtual Awaitable<Result<RunRecord>> pause_run(Caller caller, RunId run) = 0;
  // Errors: those of check_answer (run_hold.h); failed_precondition MOVING.
  virtual Awaitable<Result<RunRecord>> resume_run(Caller caller, RunId run, HoldAnswer answer) = 0;
  virtual Awaitable<Result<RunRecord>> abort_run(Caller caller, RunId run, std::string why) = 0;
  // A person says that the force the run waits for acts now. Errors: failed_precondition
  // NO_FORCE_WANTED (the run does not wait for one), invalid_argument WRONG_FORCE (another one than
  // the run waits for).
  virtual Awaitable<Result<RunRecord>> confirm_force(Caller caller, RunId run, double force_n) = 0;
  // Needs no lease; a run under way is paused. Answers within 100 ms. Until every controller has
  // reported no motion the stop is pending: what moves, and resume_run, fail with
  // failed_precondition STOP_PENDING. Survives the daemon.
  virtual Awaitable<Result<StopAnswer>> stop_all(Caller caller) = 0;
  // While a run stands both ask as resume_run does, and the run measures its zero again before its
  // next point.
  virtual Awaitable<Result<void>> home(Caller caller, std::string lease_token,
                                       HoldAnswer answer = {}) = 0;
  virtual Awaitable<Result<void>> move_to(Caller caller, std::string lease_token,
                                          std::vector<double> q_mm, HoldAnswer answer = {}) = 0;
  virtual Awaitable<Result<void>> set_stabiliser(Caller caller, std::string lease_token,
                                                 std::string device, double degc) = 0;

  // Calls back on the executor's thread with every change until the returned handle is destroyed.
  // At once with the present state.
  using Watch = std::shared_ptr<void>;
  virtual Watch watch_progress(std::function<void(const RunProgress&)> on_change) = 0;
  virtual Watch watch_events(std::function<void(const EventRecord&)> on_event) = 0;
  virtual Watch watch_readings(std::function<void(const Reading&)> on_reading) = 0;
  virtual Watch watch_snapshots(std::function<void()> on_rebuilt) = 0;

  // Queries run on the reader's thread and come back.
  virtual Awaitable<Result<std::vector<RunRecord>>> runs(int limit, std::int64_t before_id) = 0;
  virtual Awaitable<Result<RunRecord>> run(RunId run) = 0;
  virtual Awaitable<Result<std::vector<PointRecord>>> points(RunId run, std::int64_t after_id,
                                                             int limit) = 0;
  virtual Awaitable<Result<std::vector<AttemptRecord>>> attempts(RunId run) = 0;
  virtual Awaitable<Result<std::vector<DatumRecord>>> data(RunId run) = 0;
  virtual Awaitable<Result<std::vector<EventRecord>>> events(EventId after, int limit) = 0;
  // CSV text. Rows kept out of fits are marked in a column, or left out.
  virtual Awaitable<Result<std::string>> export_dataset(std::vector<RunId> runs,
                                                        bool without_excluded) = 0;
  // Becomes a run, done. The same request_id again answers with the first run.
  virtual Awaitable<Result<RunRecord>> import_dataset(Caller caller, std::string name,
                                                      std::string csv, std::string request_id) = 0;

  // Keeps rows of a run out of every fit from now on (excluded), or puts them back. The points stay
  // as they were. Rows that are so already change nothing. Errors: not_found NO_SUCH_RUN;
  // invalid_argument NO_SUCH_ROW (no accepted point in it; nothing changes then).
  virtual Awaitable<Result<ExclusionState>> exclude_rows(Caller caller, ExclusionRecord wanted) = 0;
  virtual Awaitable<Result<ExclusionState>> exclusions(RunId run) = 0;
  virtual Awaitable<Result<NoteRecord>> add_note(Caller caller, NoteSubject on,
                                                 std::string text) = 0;
  virtual Awaitable<Result<std::vector<NoteRecord>>> notes(NoteSubject on) = 0;

  virtual Awaitable<Result<ModelRecord>> fit(Caller caller,
                                             FitRequest request) = 0;  // on the worker pool
  // What the published study's further terms would add to the same fit. Errors: those of fit().
  virtual Awaitable<Result<std::vector<calibration::OfferResult>>> weigh_offers(
      FitRequest request) = 0;
  // model: none means the one that serves. runs: empty means every measured run since the model was
  // made that it was not fitted from, the last 50 of them. Errors: failed_precondition NO_MODEL.
  virtual Awaitable<Result<ModelCheck>> check_model(std::optional<ModelId> model,
                                                    std::vector<RunId> runs) = 0;
  // Errors: of the data only; what is wrong with the formula is the answer.
  virtual Awaitable<Result<FormulaCheck>> check_formula(FitRequest request) = 0;
  // runs and csv empty: the runs that it was fitted to. Errors: not_found; failed_precondition
  // NO_ROWS (it was fitted to a file); invalid_argument UNKNOWN_CHANNEL, UNTIMED.
  // Target minus measured of runs: server/diagnosis/verification.h. range: whose range says inside
  // and outside; none: each run's own model. Errors: those of verify_runs(); NO_SUCH_RUN, _MODEL.
  virtual Awaitable<Result<diagnosis::Verification>> verify_runs(std::vector<RunId> runs,
                                                                 std::optional<ModelId> range) = 0;
  virtual Awaitable<Result<ModelResiduals>> residuals(ModelId model, std::vector<RunId> runs,
                                                      std::string csv) = 0;
  virtual Awaitable<Result<std::vector<ModelRecord>>> models() = 0;
  virtual Awaitable<Result<ModelRecord>> model(ModelId id) = 0;
  // confirmed: a person has read ModelGround::promotion_questions. Errors: failed_precondition
  // NEEDS_CONFIRMATION, with the questions.
  virtual Awaitable<Result<ModelRecord>> promote(Caller caller, ModelId id,
                                                 bool confirmed = false) = 0;
  virtual Awaitable<Result<std::optional<ModelRecord>>> roll_back(
      Caller caller) = 0;  // to the one that served before
  virtual Awaitable<Result<std::vector<PromotionRecord>>> promotions() = 0;

  // The record after a cursor, alarms, series, kept trajectories.
  virtual Watching& watching() = 0;
  // Methods side by side, which thermometers suffice: studies.h.
  virtual Studies& studies() = 0;
  // Cell files that were in force, corrections, previews: provenance.h.
  virtual Provenance& provenance() = 0;
  // Diagnoses run on a thread of their own; created ones answer at once. Errors of create:
  // invalid_argument (formula, channel, NO_DATA, what diagnosis::diagnose refuses before it
  // searches); failed_precondition NO_MODEL (no baseline and nothing serves); not_found.
  virtual Awaitable<Result<DiagnosisView>> create_diagnosis(Caller caller,
                                                            DiagnosisRequest request) = 0;
  virtual Awaitable<Result<DiagnosisView>> diagnosis(DiagnosisId id) = 0;
  virtual Awaitable<Result<formats::DiscrepancyRows>> diagnosis_rows(DiagnosisId id) = 0;
  virtual Awaitable<Result<std::vector<DiagnosisView>>> diagnoses() = 0;  // newest first
  virtual Awaitable<Result<DiagnosisView>> cancel_diagnosis(Caller caller, DiagnosisId id) = 0;
  // Makes of the findings what they apply to: extension_plan.h. Errors: failed_precondition
  // NOT_DONE, NOTHING_FOUND, INDISTINGUISHABLE (a set without a choice), FROM_A_FILE,
  // OUTPUTS_DISAGREE, IMPOSSIBLE_PARAMETER (instrument_agreement.h), NEEDS_CONFIRMATION (with
  // promote); those of fit(); already_exists EXTENSION_STANDS. All of it is stored in one
  // transaction.
  virtual Awaitable<Result<ExtensionRecord>> accept_extension(Caller caller,
                                                              AcceptRequest request) = 0;
  virtual Awaitable<Result<ExtensionRecord>> undo_extension(Caller caller, DiagnosisId id) = 0;
  // The loop of improvement.h. Errors of create: as create_run's.
  virtual Awaitable<Result<ImprovementRecord>> create_improvement(Caller caller,
                                                                  ImproveRequest request) = 0;
  virtual Awaitable<Result<ImprovementRecord>> improvement(ImprovementId id) = 0;
  virtual Awaitable<Result<std::vector<ImprovementRecord>>> improvements() = 0;  // newest first
  virtual Awaitable<Result<ImprovementRecord>> cancel_improvement(Caller caller,
                                                                  ImprovementId id) = 0;
  // Of every diagnosis and improvement; at once with those under way.
  virtual Watch watch_diagnoses(std::function<void(const DiagnosisProgress&)> on_change) = 0;
  virtual Watch watch_improvements(std::function<void(const ImprovementProgress&)> on_change) = 0;

  // What serves now. Readers take no lock.
  virtual const compensation::SnapshotBoard& snapshots() const = 0;
};

}  // namespace driftwise::application
