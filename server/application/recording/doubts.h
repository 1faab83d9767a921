#pragma once
// Judgement of the devices' answers: values that nothing may use, poses that do not follow the
// axes, and what of it stands now. The tests themselves are server/plausibility. Executor's thread.

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/ports/alarm_condition.h"
#include "server/core/data/judged_reading.h"
#include "server/core/ports/load_actuator.h"
#include "server/core/ports/motion_controller.h"
#include "server/core/reasons.h"
#include "server/plausibility/frozen_in_motion.h"
#include "server/plausibility/geometry_judge.h"
#include "server/plausibility/value_judge.h"

namespace driftwise::application {

// Reason of every error here; the run waits and goes on by itself when the doubt is over.

class Doubts {
 public:
  // A doubt about something that nobody asks any more: an interferometer after the run.
  static constexpr double kForgotten_s = 600;

  // on_news: a doubt began. cell, clock, writer and events outlive this.
  Doubts(const CellDescription& cell, Clock& clock, StoreWriter& writer, EventLog& events,
         std::function<void()> on_news);

  // The reading with what was rejected of it, which is on its way to the record.
  JudgedReading judge(Reading reading);
  // Errors: IMPLAUSIBLE. The state is kept as a rejected reading then.
  Result<void> judge(const DeviceDescription& controller, const MotionState& state);
  // Says what the load says as a reading, judged.
  JudgedReading judged(const DeviceDescription& load, const LoadState& state,
                       std::int64_t sequence);

  // One round of interferometers and autocollimators, as judged above, read where the axes were at
  // q_mm. Errors: IMPLAUSIBLE, naming the first value that was rejected or did not move.
  Result<void> check_round(std::vector<JudgedReading>& round, const std::vector<double>& q_mm);
  // A pose since the datum's zero. Errors: IMPLAUSIBLE.
  Result<void> check_pose(const std::vector<ChannelValue>& pose, const std::vector<double>& q_mm);
  // By the same geometry, without raising anything. False also where it cannot be said.
  bool pose_is_at(const std::vector<ChannelValue>& pose, const std::vector<double>& q_mm) const;
  // The pose or the scale itself disagrees with where the axes are said to be: nothing is known
  // about motion by the readback now.
  bool doubts_readback() const;
  // The controller says that it is there, its scale says that it is far away. Always an error.
  Result<void> readback_is_off(const std::string& sentence);
  void readback_is_good();
  // Lengths right after their zeroing, as the instruments give them. Errors: IMPLAUSIBLE.
  Result<void> check_zero(const std::vector<ChannelValue>& raw);

  // Poses count from it now; without one no pose is compared with the readback.
  void take_datum(const DatumRecord& datum) { datum_ = datum; }
  void forget_datum() { datum_.reset(); }
  bool has_datum() const { return datum_.has_value(); }  // opened since the start
  // New reference of one device: its next answer is taken as right (it was zeroed, homed, loaded).
  void begin_anew(const std::string& device) { values_.begin_anew(device); }
  // ... and all of them: a run begins, a person resumed it.
  void begin_anew();

  // Points measured from this instant on rest on an instrument that was found false only later;
  // asked for once.
  struct Suspicion {
    CellTime since;
    std::string reason;
  };
  std::optional<Suspicion> take_suspicion() { return std::exchange(suspicion_, std::nullopt); }

  // Conditions that stand now, for the alarms.
  std::vector<AlarmCondition> conditions() const;

 private:
  struct Standing {
    std::string kind, message;
    CellTime last;            // when it was seen last
    bool good_again = false;  // it was plausible since then
  };
  void begin(const std::string& subject, const std::string& kind, const std::string& message);
  void end(const std::string& subject);
  void note_controller(const DeviceDescription& controller, const MotionState& state);
  bool may_freeze(const DeviceDescription& device) const;
  Error implausible(const std::string& sentence) const;
  // Axes of the robot that this channel is of.
  std::vector<double> of_robot(const std::vector<double>& q_mm, const std::string& symbol) const;
  std::vector<ChannelValue> motor_values(const std::vector<double>& q_mm) const;

  const CellDescription& cell_;
  Clock& clock_;
  StoreWriter& writer_;
  EventLog& events_;
  std::function<void()> on_news_;
  plausibility::ValueJudge values_;
  plausibility::GeometryJudge geometry_;
  plausibility::FrozenInMotion moved_;
  std::optional<DatumRecord> datum_;
  // By channel, or "pose", "readback", "zero", "servo of <controller>".
  std::map<std::string, Standing> standing_;
  std::optional<Suspicion> suspicion_;
};

}  // namespace driftwise::application
