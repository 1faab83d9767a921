#pragma once

#include "server/application/annotations/annotations.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"

namespace driftwise::application {

class AnnotationsService final : public Annotations {
 public:
  AnnotationsService(Clock& clock, StoreReader& reader, StoreWriter& writer, EventLog& events)
      : clock_(clock), reader_(reader), writer_(writer), events_(events) {}

  Awaitable<Result<ExclusionState>> exclude_rows(Caller caller, ExclusionRecord wanted) override;
  Awaitable<Result<ExclusionState>> exclusions(RunId run) override;
  Awaitable<Result<NoteRecord>> add_note(Caller caller, NoteSubject on, std::string text) override;

 private:
  Clock& clock_;
  StoreReader& reader_;
  StoreWriter& writer_;
  EventLog& events_;
};

}  // namespace driftwise::application
