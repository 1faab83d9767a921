#pragma once
// What leaves the machine: [[notify]], [watchdog] and [[channel_alarm]] of a cell file. Plain data.
// Text form: docs/cell-file.md.

#include <optional>
#include <string>
#include <vector>

namespace driftwise {

// One receiver of alarms. Exactly one of webhook, smtp and command is given.
struct ReceiverDescription {
  std::string name;
  std::string webhook;               // URL that takes Alertmanager's webhook JSON, version 4
  std::string smtp;                  // "smtps://mail.example.org:465", "smtp://127.0.0.1:25"
  std::vector<std::string> command;  // program and arguments, without a shell
  // Of a webhook: sent as "Authorization: Bearer ...". File, absolute, mode 0600.
  std::string token_file;
  // Of smtp. The password is the first line of the file (absolute, mode 0600).
  std::string from, user, password_file;
  std::vector<std::string> to;
  std::string ca_file;  // PEM of the authority that signed the receiver; empty: those of the system

  std::vector<std::string> levels;  // "warning"; empty: all
  std::vector<std::string> kinds;   // "device.lost", "run.*"; empty: all
  // Local time of the computer, minutes of the day; equal: the whole day. A span that crosses
  // midnight belongs to the day on which it begins.
  int from_minute = 0, to_minute = 0;
  unsigned days = 0x7f;  // bit 0: Monday
  double repeat_h = 4;   // until it is acknowledged; 0: once
  double group_s = 10;   // what begins within it goes in one message
  bool resolved = true;  // the end is told as well
};

// [watchdog]: a sign of life to another machine, which raises the alarm when none arrives.
struct WatchdogRules {
  std::string url;           // empty: none
  double every_s = 30;       // wall time
  std::string token_file;    // as above
  std::string ca_file = {};  // as above
};

// [[channel_alarm]]: a limit of a user's own, exactly one of above and below.
struct ChannelAlarmDescription {
  std::string channel;
  std::optional<double> above, below;  // in the channel's unit
  double hysteresis = 0;               // it is over when the value is this far back
  double for_s = 0;                    // the value is beyond the limit for so long before it begins
  std::string priority = "medium";     // low, medium, high, critical
  std::string sentence;                // what to do; empty: none
};

}  // namespace driftwise
