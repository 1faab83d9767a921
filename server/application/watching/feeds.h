#pragma once
// Feeds: calls back on the executor's thread with every event, reading or change of the record,
// until the returned handle is destroyed.

#include <functional>
#include <memory>

#include "server/core/data/reading.h"
#include "server/core/records/records.h"

namespace driftwise::application {

class Feeds {
 public:
  virtual ~Feeds() = default;

  virtual std::shared_ptr<void> watch_events(std::function<void(const EventRecord&)> on_event) = 0;
  virtual std::shared_ptr<void> watch_readings(std::function<void(const Reading&)> on_reading) = 0;
  // When there is something new in the record, whatever it is.
  virtual std::shared_ptr<void> watch_records(std::function<void()> on_news) = 0;
};

}  // namespace driftwise::application
