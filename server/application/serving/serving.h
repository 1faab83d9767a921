#pragma once
// The model at work: fed with every reading, anchored to the present datum, folded into snapshots.
// Executor's thread; only the board is read by others.

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "server/application/plumbing/lag_meter.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/provenance/configuration_book.h"
#include "server/application/provenance/model_origin.h"
#include "server/application/recording/recorder.h"
#include "server/application/serving/targets.h"
#include "server/compensation/snapshot_board.h"
#include "server/compensation/snapshot_builder.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

class Serving final : public Targets {
 public:
  Serving(asio::any_io_executor executor, const CellDescription& description,
          const ConfigurationBook& configuration, Clock& clock, Recorder& recorder,
          StoreReader& reader, EventLog& events, TaskGroup& tasks);

  void start();  // rebuilds every rebuild_period_s and when a slow channel of the model arrives,
                 // until shut_down()
  void shut_down();

  // Serves this model from now on; none: no model serves. Readings of the last hours bring its
  // memory up to date. Errors: those of read_model_json and SnapshotBuilder::create; the board
  // keeps what it had.
  Awaitable<Result<void>> serve(std::optional<ModelRecord> model);
  // This model should serve and cannot: every target is refused with this error, and no other model
  // takes its place, until serve().
  void refuse(ModelId model, Error why);
  // Follows a model for a compensated run, beside the one that serves, until another run's is
  // followed. Does nothing when it is followed already.
  Awaitable<Result<void>> follow(ModelRecord model);
  // Measurements disagree with this model: its targets say so. None: with no model.
  void doubt(std::optional<ModelId> model);
  bool is_doubtful(ModelId model) const { return doubtful_ == model; }
  // The question of the cell file was answered.
  void look_again() { rebuild(); }
  // The zeroing that is in force. Everything followed is anchored to it.
  void anchor(const DatumRecord& datum);

  // Motor coordinates of all axes of the cell for a pose, from a snapshot of this moment.
  // model: none means the one that serves. Errors: those of compensation::refusal_error; not_found
  // MODEL_NOT_FOLLOWED; failed_precondition NOT_ALL_AXES (the model gives some motor coordinates
  // only).
  Result<std::vector<double>> targets(const std::vector<Channel>& coordinates,
                                      const TrajectoryPoint& point,
                                      std::optional<ModelId> model) const;

  // Targets.
  const compensation::SnapshotBoard& snapshots() const override { return board_; }
  std::shared_ptr<void> watch_snapshots(std::function<void()> on_rebuilt) override;
  Awaitable<Result<PastTargets>> past(PastTargetsQuery query) const override;

  std::optional<ModelId> model() const { return serving_; }
  const std::optional<Error>& refused() const { return refused_; }
  const std::optional<DatumRecord>& datum() const { return datum_; }  // in force; none: not known
  std::string trouble() const;  // of the model that serves, a sentence for people; empty: none

 private:
  struct Followed {
    compensation::SnapshotBuilder builder;
    ModelOrigin origin;
    std::string trouble = {};  // why the present datum does not anchor it
  };
  // The followed model's, with what an open question of the cell file does to it.
  compensation::Snapshot snapshot_of(const Followed& followed, CellTime now) const;
  Awaitable<Result<Followed>> load(ModelRecord model);
  void set_anchor(ModelId id, Followed& followed);
  // Drops the models that neither serve nor compensate the run that was prepared last.
  void forget_others();
  void observe(const Reading& reading);
  void rebuild();
  Awaitable<void> rebuild_for_ever();

  asio::any_io_executor executor_;
  const CellDescription& description_;
  const ConfigurationBook& configuration_;
  Clock& clock_;
  Recorder& recorder_;
  StoreReader& reader_;
  EventLog& events_;
  TaskGroup& tasks_;
  compensation::SnapshotBoard board_;
  WatchList<> watchers_;
  std::map<ModelId, Followed> followed_;
  std::optional<ModelId> serving_, compensating_;  // compensating: the run prepared last
  std::optional<Error> refused_;                   // nothing serves because of this
  std::optional<ModelId> doubtful_;
  std::optional<DatumRecord> datum_;
  std::shared_ptr<void> watch_;
  CellTime built_at_;
  Signal ended_;
  bool ending_ = false;
};

}  // namespace driftwise::application
