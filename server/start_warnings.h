#pragma once
// Files that a cell file names and that cannot be used now: no reason not to measure.

#include "server/core/description/cell_description.h"

namespace driftwise {

// To the log, each as one warning: a certificate out of its time, a receiver's secret file that is
// missing, empty or readable by others. A running daemon raises an alarm of the same.
void warn_of_certificate(const AccessDescription& access);
void warn_of_secrets(const std::vector<ReceiverDescription>& receivers,
                     const WatchdogRules& watchdog);

}  // namespace driftwise
