#pragma once
// Looks at the [[hold]] rules with every reading, run or no run, and sets or ends the condition of
// the run under way. It ends what it set itself and nothing else: a person's pause or stop stays.

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/application/holds/holds.h"
#include "server/application/motion/workbench.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/runs/hold_mark.h"

namespace driftwise::application {

class HoldDesk final : public Holds {
 public:
  static constexpr double kLook_s = 1;          // cell time between two looks,
  static constexpr double kLeastWall_s = 0.02;  // and wall time, in a simulated cell at speed

  struct World {                                          // each on the executor's thread
    std::function<RunControl*()> control;                 // of the run under way; nullptr: none
    std::function<bool()> measures;                       // it has a datum
    std::function<void()> end_daemon;                     // in good order
    std::function<std::optional<double>()> disk_free_gb;  // of the database's disk; none: not known
    std::function<void()> stop_axes;                      // of the run under way; returns at once
  };
  // All of them outlive this.
  HoldDesk(asio::any_io_executor executor, const CellDescription& description, Clock& clock,
           const Recorder& recorder, EventLog& events, TaskGroup& tasks, World world);

  void start();  // looks until shut_down()
  void shut_down();

  // Before a run moves for the first time, and before it is gone on with: what is exceeded now
  // holds at once.
  void look_before_motion(RunControl& control);
  // Stretches of the rules that mark points: those that hold now, and those that have ended since
  // this was asked last, each from the first value beyond the limit on.
  std::vector<HoldMark> take_marks();

  // Something keeps a run, and all that does is within its release limits: the settle time is
  // counted.
  bool settles() const;

  std::vector<HoldStatus> list() const override;
  Awaitable<Result<HoldStatus>> set_aside(Caller caller, std::string name, double for_s,
                                          std::string reason) override;

 private:
  struct Rule {
    HoldWatch watch;
    CellTime aside_until = {};
    CellTime marks_from = {};  // it was set aside before
    std::string aside_by = {}, aside_reason = {};
    bool told = false;                     // that it holds, as an event
    std::optional<HoldMark> marking = {};  // while it holds, counts and marks
  };
  Awaitable<void> look_for_ever();
  void look(HoldWatch::Look look);
  void tell(Rule& rule);
  void follow_mark(Rule& rule);
  // True: the axes have to be stopped now.
  [[nodiscard]] bool apply(RunControl* control);
  void end_where_it_must();
  bool counts(const Rule& rule) const;
  std::optional<double> value_of(const HoldRule& rule) const;
  std::optional<double> fresh(const std::string& channel,
                              const std::optional<double>& stale_s) const;
  HoldStatus status_of(const Rule& rule) const;

  asio::any_io_executor executor_;
  const CellDescription& description_;
  Clock& clock_;
  const Recorder& recorder_;
  EventLog& events_;
  TaskGroup& tasks_;
  World world_;
  std::vector<Rule> rules_;
  std::vector<HoldMark> ended_marks_;  // of holds that are over, not taken yet
  Signal wake_;
  bool ending_ = false, asked_to_end_ = false;
};

}  // namespace driftwise::application
