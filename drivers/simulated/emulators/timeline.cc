#include "drivers/simulated/emulators/timeline.h"

namespace driftwise::simulated {

Timeline::EventId Timeline::at(TimeNs due, Action action) {
  const EventId id{due, ++last_};
  events_.emplace(id, std::move(action));
  return id;
}

std::optional<TimeNs> Timeline::next() const {
  if (events_.empty()) return std::nullopt;
  return events_.begin()->first.first;
}

void Timeline::run_next() {
  if (events_.empty()) return;
  auto node = events_.extract(events_.begin());
  node.mapped()(node.key().first);
}

}  // namespace driftwise::simulated
