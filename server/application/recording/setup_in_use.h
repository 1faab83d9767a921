#pragma once
// Set-up in use: which instruments it leaves out, which it can do without, and the names of what a
// second instrument confirms.

#include <string>

#include "server/core/data/reading.h"
#include "server/core/description/cell_description.h"

namespace driftwise::application {

class SetupInUse {
 public:
  // nullptr: every instrument is in use. setup: outlives its use.
  void use(const SetupDescription* setup) { setup_ = setup; }
  const SetupDescription* get() const { return setup_; }

  // It measures the pose and is not named by the set-up.
  bool leaves_out(const DeviceDescription& device) const;
  // Every coordinate that it takes from this device may be out of range.
  bool may_lose(const std::string& device) const;
  // A reading that a second instrument confirms has a name of its own in everything that comes
  // after it.
  Reading under_confirming_names(Reading reading) const;

 private:
  const SetupDescription* setup_ = nullptr;
};

}  // namespace driftwise::application
