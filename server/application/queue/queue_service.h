#pragma once

#include "server/application/queue/queue.h"
#include "server/application/queue/queue_desk.h"
#include "server/application/trajectories/trajectories.h"

namespace driftwise::application {

class QueueService final : public Queue {
 public:
  // All of them outlive this.
  QueueService(const CellDescription& description, Clock& clock, EventLog& events,
               Trajectories& trajectories, Models& models, QueueDesk& desk)
      : description_(description),
        clock_(clock),
        events_(events),
        trajectories_(trajectories),
        models_(models),
        desk_(desk) {}

  Awaitable<Result<QueueLine>> add(Caller caller, QueueDraft draft) override;
  Awaitable<Result<QueueLine>> change(Caller caller, QueueEntryId id, QueueEdit edit) override;
  Awaitable<Result<QueueLine>> move(Caller caller, QueueEntryId id,
                                    std::optional<QueueEntryId> before) override;
  Awaitable<Result<QueueLine>> remove(Caller caller, QueueEntryId id, std::string reason) override;
  Awaitable<Result<QueueHold>> hold(Caller caller, std::string reason) override;
  Awaitable<Result<void>> release(Caller caller) override;
  QueueView list() const override;
  Result<QueueLine> get(QueueEntryId id) const override;

 private:
  Result<void> check_terms(QueueEntry& entry) const;
  Result<QueueEntry> open_entry(QueueEntryId id, const char* verb) const;

  const CellDescription& description_;
  Clock& clock_;
  EventLog& events_;
  Trajectories& trajectories_;
  Models& models_;
  QueueDesk& desk_;
};

}  // namespace driftwise::application
