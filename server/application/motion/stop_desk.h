#pragma once
// A stop as a state: kept in the database before it is sent, pending until each motion controller
// has itself reported no motion in two successive answers. An acknowledgement of the command ends
// nothing. While a stop is pending it is sent again after every failure and every restart. It is
// over once it is confirmed and on record: a stop that the database refuses is written again until
// it takes it. check() refuses every motion before. Executor's thread.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/ports/caller.h"
#include "server/core/ports/motion_controller.h"
#include "server/core/records/stop_record.h"

namespace driftwise::application {

// What became of a stop within the time of its answer.
struct StopAnswer {
  bool confirmed = false;           // every controller has reported no motion twice in succession
  std::string message;              // a sentence; not confirmed: "... use the emergency switch ..."
  std::vector<StopRecord> pending;  // by controller: those that have not confirmed
};

class StopDesk {
 public:
  struct Controller {
    std::string id;                                         // device id in the cell file
    std::function<Awaitable<Result<void>>()> stop;          // MotionController::stop
    std::function<Awaitable<Result<MotionState>>()> state;  // MotionController::state
  };
  static constexpr int kAnswers = 2;  // successive answers of no motion that end a stop

  StopDesk(asio::any_io_executor executor, Clock& clock, StoreWriter& writer, EventLog& events,
           TaskGroup& tasks, std::vector<Controller> controllers);

  // What the database has pending. Before start(). A stop of a controller that the cell no longer
  // has is pending for all of them.
  void restore(std::vector<StopRecord> pending);
  // Sends what is pending. Before anything else asks a device.
  void start();
  void shut_down();  // the tasks end after the exchange under way; the TaskGroup says when
  // After the tasks have ended: one more try to store what is not on record.
  Awaitable<void> keep_for_the_next_start();
  // A stop that the database has not taken: the next start does not know of it. None: all are on
  // record.
  std::optional<StopRecord> unstored() const;

  // Pending at once. The command is sent when the database has it or refuses it, or after 40 ms of
  // wall time: a disk never delays a stop by more. Answers within 80 ms of wall time, confirmed or
  // not. held_at: since when a run is held by it (RunHold); none: since now.
  Awaitable<StopAnswer> press(Caller caller, std::string cause,
                              std::optional<CellTime> held_at = {});

  // Called at every press, before anything else is done about it.
  void tell_presses(std::function<void(const Caller&, const std::string& cause)> to) {
    on_press_ = std::move(to);
  }

  // Cause of a stop that was pending at the start, confirmed since or not: the run that was under
  // way then is not continued.
  const std::optional<std::string>& cause_at_start() const { return cause_at_start_; }
  bool pending() const;                     // a controller has not confirmed
  std::vector<StopRecord> records() const;  // those pending, in the order of the controllers
  // Errors: failed_precondition STOP_PENDING: whose stop, which controller, why it is not over yet,
  // what to do.
  Result<void> check() const;
  // One sentence per controller whose stop has been pending for longer than an answer takes.
  struct Unconfirmed {
    std::string controller, sentence;
  };
  std::vector<Unconfirmed> unconfirmed() const;

 private:
  struct Place {
    Controller controller;
    std::optional<StopRecord> stop;  // until it is confirmed and on record
    bool stored = false, confirming = false, late = false;
    std::string trouble;  // why it is not confirmed yet
    bool is_confirmed() const { return stop && stop->confirmed.utc_ns != 0; }
  };
  void begin_confirming(Place& place);
  void keep_soon();
  Awaitable<void> keep_while_asked();
  Awaitable<void> keep();
  void note_rest(Place& place);
  Awaitable<void> send(Place& place);
  Awaitable<void> confirm(Place& place);
  Awaitable<bool> at_rest(Place& place);
  Awaitable<void> end(Place& place);
  Awaitable<void> end_orphans();
  bool all_stored() const;
  bool is_over() const;
  StopAnswer answer() const;
  Nanoseconds of_wall(std::chrono::milliseconds wall) const;  // as cell time at the present speed
  std::string sentence(const Place& place) const;

  asio::any_io_executor executor_;
  Clock& clock_;
  StoreWriter& writer_;
  EventLog& events_;
  TaskGroup& tasks_;
  std::vector<Place> places_;        // never grows: coroutines refer into it
  std::vector<StopRecord> orphans_;  // pending, of controllers that the cell no longer has
  std::optional<std::string> cause_at_start_;
  std::string refusal_;  // of the database, at the last try; empty: it took it
  bool ending_ = false, keeping_ = false, keep_again_ = false;
  Signal changed_, pressed_;
  std::function<void(const Caller&, const std::string&)> on_press_;
};

}  // namespace driftwise::application
