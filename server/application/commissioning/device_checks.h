#pragma once
// Comparison of what a device says with what the cell file expects of it. Pure.

#include <span>
#include <vector>

#include "server/application/commissioning/commissioning.h"
#include "server/application/recording/device_status.h"
#include "server/core/data/judged_reading.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/motion_controller.h"

namespace driftwise::application {

// Last answers of one device.
struct Heard {
  DeviceStatus status;
  std::optional<Error> trouble;         // it did not answer, or not with a reading
  std::vector<JudgedReading> readings;  // one after the other; empty: none was asked for
  std::optional<MotionState> motion;    // of a controller
};

// Light below it is too little: the maker's own warning comes at a few per cent, and alignment is
// lost slowly.
constexpr double kEnoughLight_pct = 30;

// now: instant of the last answer; utc_ns: the day of it; speed: cell seconds per wall second, for
// a link costs wall time.
std::vector<CheckItem> check_device(const CellDescription& cell, const Heard& heard, CellTime now,
                                    std::int64_t utc_ns, double speed);

// Sentences on certificates that are overdue, for the attention of people.
struct OverdueCertificate {
  std::string subject, sentence;
};
std::vector<OverdueCertificate> overdue_certificates(const CellDescription& cell,
                                                     std::int64_t utc_ns);

}  // namespace driftwise::application
