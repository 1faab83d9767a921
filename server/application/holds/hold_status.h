#pragma once
// A [[hold]] rule and how it stands now.

#include <string>

#include "server/application/holds/hold_watch.h"

namespace driftwise::application {

struct HoldStatus {
  HoldRule rule;
  HoldWatch::Phase phase = HoldWatch::Phase::clear;
  CellTime since;                 // of exceeded and holding; utc_ns 0 while clear
  std::string sentence, outlook;  // as HoldWatch gives them
  CellTime aside_until;           // it suspends nothing until then; utc_ns 0: it counts
  std::string aside_by, aside_reason;
};

}  // namespace driftwise::application
