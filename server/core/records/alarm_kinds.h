#pragma once
// Kinds of the alarms that the daemon raises. A receiver names them in the cell file, alone or by
// their beginning ("run.*").

#include <array>
#include <string_view>

namespace driftwise {

inline constexpr std::array kAlarmKinds =
    std::to_array<std::string_view>({"access.ends",
                                     "access.wrong_tries",
                                     "backup.failed",
                                     "certificate.ends",
                                     "certificate.overdue",
                                     "certificate.revocations",
                                     "certificate.unusable",
                                     "channel.critical",
                                     "channel.limit",
                                     "channel.stale",
                                     "clock.behind",
                                     "clock.stepped",
                                     "closure.bad",
                                     "configuration.changed",
                                     "daemon.paused",
                                     "database.damaged",
                                     "database.files",
                                     "database.log_gone",
                                     "device.clock",
                                     "device.lost",
                                     "device.unused",
                                     "disk.forecast",
                                     "door.unreached",
                                     "gate.given_up",
                                     "gate.spread",
                                     "load.on",
                                     "model.damaged",
                                     "model.doubtful",
                                     "motion.servo_off",
                                     "motion.uncommanded",
                                     "notify.failed",
                                     "pose.disagrees",
                                     "queue.done",
                                     "queue.failed",
                                     "queue.follow_up_failed",
                                     "queue.held",
                                     "queue.set_aside",
                                     "readback.disagrees",
                                     "reading.frozen",
                                     "reading.missing",
                                     "reading.not_finite",
                                     "reading.range",
                                     "reading.step",
                                     "reading.together",
                                     "record.dropped",
                                     "record.unwritten",
                                     "run.begins_soon",
                                     "run.failed",
                                     "run.moves_soon",
                                     "run.paused",
                                     "run.waiting",
                                     "serving.trouble",
                                     "stop.unconfirmed",
                                     "supply.forced",
                                     "watchdog.unreached",
                                     "zero.disagrees"});

}  // namespace driftwise
