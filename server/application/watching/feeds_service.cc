#include "server/application/watching/feeds_service.h"

#include <vector>

namespace driftwise::application {

std::shared_ptr<void> FeedsService::watch_events(std::function<void(const EventRecord&)> on_event) {
  return events_.watchers().add(std::move(on_event));
}

std::shared_ptr<void> FeedsService::watch_readings(std::function<void(const Reading&)> on_reading) {
  return recorder_.watchers().add(std::move(on_reading));
}

std::shared_ptr<void> FeedsService::watch_records(std::function<void()> on_news) {
  auto watches = std::make_shared<std::vector<std::shared_ptr<void>>>();
  watches->push_back(events_.watchers().add([on_news](const EventRecord&) { on_news(); }));
  watches->push_back(engine_.watchers().add([on_news](const RunProgress&) { on_news(); }));
  watches->push_back(alarms_.watchers().add([on_news](const AlarmRecord&) { on_news(); }));
  // What a diagnosis tells of its progress is on no record: only its end is.
  watches->push_back(desk_.watchers().add([on_news](const DiagnosisProgress& progress) {
    if (progress.state != JobState::running) on_news();
  }));
  watches->push_back(
      improver_.watchers().add([on_news](const ImprovementProgress&) { on_news(); }));
  return watches;
}

}  // namespace driftwise::application
