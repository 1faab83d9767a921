#pragma once
// Motion that this daemon did not command, and commanded motion that the controller ended itself:
// each answer of the controller is compared with what was commanded last. Pure.
//
// Two computers cannot see each other's locks (server/locks), a controller may have a hand wheel,
// and an axis may run away: all of them show here and nowhere else.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/channel.h"
#include "server/core/ports/motion_controller.h"

namespace driftwise::application {

struct MotionFinding {
  enum class Kind {
    moved,      // the axes moved without a command: somebody else, or they ran away
    halted,     // the controller ended the commanded motion, and says why
    servo_off,  // a drive lost its current: an emergency stop, a person, the controller itself
  };
  Kind kind = Kind::moved;
  std::string sentence;
};

class MotionWatch {
 public:
  // limit_nm: an axis at rest that was read back farther away than this has moved. Ten times the
  // in-position window of the run's rules: far above what a loop that holds its place leaves (25 to
  // 35 nm), far below what any row moves.
  static constexpr double kPerInPosition = 10;

  MotionWatch(std::vector<Channel> motors, double limit_nm)
      : motors_(std::move(motors)), limit_nm_(limit_nm) {}

  // A move to this place was sent, or may have been.
  void commanded(std::vector<double> q_mm);
  // Homing, a stop, a refused move: where the axes rest next is where they are.
  void released();
  // The controller could not be asked: a move under way may have been ended by its own watchdog.
  void lost();
  // Fate of the axes without a command, once: afterwards as released(). Another target than
  // the commanded one counts when it is seen twice in succession: an answer may be made of a
  // position and a flag that are not of one instant.
  std::optional<MotionFinding> look(const MotionState& state);
  // Where the axes should be, as far as that is known; else empty.
  const std::vector<double>& expected_mm() const { return q_mm_; }
  // Of commanded(), released() and lost(): an answer that was on its way at one is not looked at.
  std::int64_t orders() const { return orders_; }

 private:
  enum class Expected { anything, under_way, at_rest };
  void forget();
  std::optional<std::string> farther_than_limit(const MotionState& state, const char* what) const;

  std::vector<Channel> motors_;
  double limit_nm_;
  Expected expected_ = Expected::anything;
  std::vector<double> q_mm_;  // under_way: commanded; at_rest: read back
  bool elsewhere_ = false;    // under_way: on target elsewhere at the last look
  std::int64_t orders_ = 0;
};

}  // namespace driftwise::application
