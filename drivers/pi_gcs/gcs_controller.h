#pragma once
// The loop behind MotionController for one GCS 2.0 controller. Use make_pi_gcs (pi_gcs.h).
//
// stop() may come while another call is under way, so every call locks the line here
// too. stop() does not wait: it writes 0x18 at once, ends the call under way with aborted (STOPPED)
// and then locks the line to bring it back in step and to clear error 10; calls that were
// waiting end with aborted too. Until two successive answers of state() report no motion, 0x18 is
// the first byte on every new connection.
//
// A setter is followed by ERR? in the same message. Its answer is the setter's verdict only where
// the controller held no error before: ERR? is asked first, unless the last answer on this
// connection was ERR? with 0. What is found there is told as MotionState::old_error.
//
// A set-up reads the servo and leaves it as it is: a drive may have been switched off by an
// emergency stop. home() alone sends SVO 1.

#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/pi_gcs/gcs_options.h"
#include "drivers/pi_gcs/start_trap.h"
#include "drivers/transport/line_device.h"
#include "server/core/ports/async_mutex.h"
#include "server/core/ports/motion_controller.h"
#include "server/locks/claims.h"

namespace driftwise::gcs {

class GcsController final : public transport::LineDevice<MotionController> {
 public:
  GcsController(DeviceDescription device, Options options, const transport::Address& address,
                asio::any_io_executor executor, Clock& clock,
                std::shared_ptr<locks::Claims> claims = nullptr);

  Awaitable<Result<void>> prepare() override;
  void close() override;
  Awaitable<Result<MotionState>> state() override;
  Awaitable<Result<void>> home() override;
  Awaitable<Result<void>> start_move(std::span<const double> q_mm) override;
  Awaitable<Result<void>> stop() override;

 private:
  using Text = Awaitable<Result<std::string>>;
  // Below: the caller holds the lock.
  Awaitable<Result<void>> get_ready(std::int64_t stops_seen);
  Awaitable<Result<void>> tidy_after_stop();
  Awaitable<Result<void>> set_up() override;
  Result<void> claim(const std::string& key);  // this controller is ours, or nobody claims here
  Awaitable<Result<void>> refresh_servo();
  Awaitable<Result<void>> check_travel();
  Awaitable<Result<void>> command(std::string text);  // setter + ERR?
  Awaitable<Result<void>> refused_by_error_5(std::string text);
  Awaitable<Result<int>> take_error_number();
  Result<int> error_number(std::string_view reply);
  void note_old_error(int number, const std::string& found);
  Awaitable<Result<void>> look_at_end_of_motion();
  Text ask(std::string query) {
    holds_no_error_ = false;
    return link_.ask(std::move(query), timeout_);
  }
  using Fetched = std::deque<std::string>;
  Awaitable<Result<Fetched>> fetch(std::vector<std::string> queries);  // empty without pipelining
  Text next(Fetched& fetched, std::string query);  // ... and then asked one by one
  Awaitable<Result<void>> refresh_referenced();
  Awaitable<Result<MotionState>> read_state();

  Awaitable<Result<void>> start_referencing(std::int64_t stops_seen);
  Awaitable<Result<MotionState>> look(std::int64_t stops_seen, bool also_referenced);
  Result<void> check_soft_limits(std::span<const double> q_mm) const;
  template <class T>
  Result<T> checked(Result<T> parsed) {  // adds the exchange to a codec's error
    if (parsed) return parsed;
    link_.lose_step();
    return link_.wrong_reply(parsed.error());
  }
  tl::unexpected<Error> stopped() const;

  Options options_;
  std::shared_ptr<locks::Claims> claims_;
  AsyncMutex mutex_;
  std::vector<std::string> axes_;
  StartTrap trap_;
  std::int64_t stops_ = 0;         // a call that sees this change has been stopped
  int stopping_ = 0;               // stops that have not come back yet
  std::int64_t tidied_stops_ = 0;  // the line was brought in step after this many
  Result<void> tidied_;            // ... with this outcome
  bool stop_owed_ = false;         // stopped, and motion may not have ended
  int answers_at_rest_ = 0;        // successive answers of no motion since the last stop
  bool referenced_ = false;
  bool servo_on_ = true;         // as SVO? said it last, of all axes
  bool holds_no_error_ = false;  // the last answer was ERR? with 0
  bool has_ended_ = true;        // the end of the last motion was looked at
  std::string halted_because_, old_error_;
};

}  // namespace driftwise::gcs
