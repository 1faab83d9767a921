#pragma once
// The plan at work: its models fed with every reading, anchored to the present datum, folded into
// joint snapshots. Executor's thread; only the board is read by others.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/application/plans/joint_targets.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/provenance/configuration_book.h"
#include "server/application/provenance/model_origin.h"
#include "server/application/recording/recorder.h"
#include "server/application/serving/serving.h"
#include "server/plans/joint_builder.h"

namespace driftwise::application {

class JointServing final : public JointTargets {
 public:
  // serving: tells of every new datum.
  JointServing(asio::any_io_executor executor, const CellDescription& description,
               const ConfigurationBook& configuration, Clock& clock, Recorder& recorder,
               StoreReader& reader, EventLog& events, TaskGroup& tasks, Serving& serving);

  void start();
  void shut_down();

  // Serves this plan from now on. Readings of the last hours bring its memory up to date. Errors:
  // those of JointBuilder::create; the board keeps what it had.
  Awaitable<Result<void>> serve(PlanId id, plans::ServingPlan plan, plans::ModelsById models);
  void serve_none();
  // This plan should serve and cannot: every joint target is refused with this error.
  void refuse(PlanId id, Error why);

  const plans::JointBoard& board() const override { return board_; }
  std::optional<PlanId> plan() const {
    return followed_ ? std::optional(followed_->id) : std::nullopt;
  }
  const std::optional<Error>& refused() const { return refused_; }  // none serves because of this
  // Of this moment: what the board will show next.
  plans::JointSnapshot snapshot_now() const;
  std::string trouble() const;  // a sentence for people; empty: none

 private:
  struct Followed {
    PlanId id;
    plans::JointBuilder builder;
    std::map<ModelId, ModelOrigin> origins;
    std::string trouble;
  };
  void anchor();
  void observe(const Reading& reading);
  void on_serving();
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
  Serving& serving_;
  plans::JointBoard board_;
  std::optional<Followed> followed_;
  std::optional<Error> refused_;
  std::optional<DatumId> anchored_to_;
  std::shared_ptr<void> readings_, datums_;
  CellTime built_at_;
  Signal ended_;
  bool ending_ = false;
};

}  // namespace driftwise::application
