#pragma once

#include "server/application/alarms/alarm_book.h"
#include "server/application/diagnoses/diagnosis_desk.h"
#include "server/application/improvement/improver.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/recording/recorder.h"
#include "server/application/runs/run_engine.h"
#include "server/application/watching/feeds.h"

namespace driftwise::application {

class FeedsService final : public Feeds {
 public:
  FeedsService(EventLog& events, Recorder& recorder, RunEngine& engine, AlarmBook& alarms,
               DiagnosisDesk& desk, Improver& improver)
      : events_(events),
        recorder_(recorder),
        engine_(engine),
        alarms_(alarms),
        desk_(desk),
        improver_(improver) {}
  std::shared_ptr<void> watch_events(std::function<void(const EventRecord&)> on_event) override;
  std::shared_ptr<void> watch_readings(std::function<void(const Reading&)> on_reading) override;
  std::shared_ptr<void> watch_records(std::function<void()> on_news) override;

 private:
  EventLog& events_;
  Recorder& recorder_;
  RunEngine& engine_;
  AlarmBook& alarms_;
  DiagnosisDesk& desk_;
  Improver& improver_;
};

}  // namespace driftwise::application
