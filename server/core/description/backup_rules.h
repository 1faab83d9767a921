#pragma once

#include <string>

namespace driftwise {

// [backup] of the cell file.
struct BackupRules {
  std::string folder;  // absolute; empty: "backups" beside the database
  double every_h = 0;  // cell time between two by the schedule; 0: only when somebody asks
  int keep = 14;       // the newest so many stay
};

}  // namespace driftwise
