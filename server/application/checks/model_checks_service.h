#pragma once
// Asked by people, and by the cell itself after every run and when another model serves.

#include <boost/asio/any_io_executor.hpp>
#include <string>

#include "server/application/checks/model_checks.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/runs/run_progress.h"
#include "server/application/serving/serving.h"

namespace driftwise::application {

class ModelChecksService final : public ModelChecks {
 public:
  // worker: where the figures are worked out. All of them outlive this.
  ModelChecksService(asio::any_io_executor worker, StoreReader& reader, EventLog& events,
                     Serving& serving, TaskGroup& tasks)
      : worker_(std::move(worker)),
        reader_(reader),
        events_(events),
        serving_(serving),
        tasks_(tasks) {}

  Awaitable<Result<ModelCheck>> check_model(std::optional<ModelId> id, std::vector<RunId> runs,
                                            std::optional<CorrectionId> leaving_out) override;
  Awaitable<Result<diagnosis::Verification>> verify_runs(std::vector<RunId> runs,
                                                         std::optional<ModelId> range) override;

  // The model that serves is checked: another one serves (any: false, none); a run has ended.
  void served_another(bool any);
  void check_after(const RunProgress& progress);
  // "recalibrate now: ...", of the model that serves; empty: none.
  const std::string& trouble() const { return trouble_; }

 private:
  void set_trouble(std::string trouble);  // empty: none. Targets have a flag meanwhile
  Awaitable<void> check_served(std::optional<RunId> after);

  asio::any_io_executor worker_;
  StoreReader& reader_;
  EventLog& events_;
  Serving& serving_;
  TaskGroup& tasks_;
  std::string trouble_;
  std::optional<RunId> checked_;  // the last run that was looked at when it ended
};

}  // namespace driftwise::application
