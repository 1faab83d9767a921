#pragma once
// The record of access: what the doors refused becomes events and alarms. A certificate that is
// about to end, and a door whose address the computer does not have, are alarms. note() on any
// thread, everything else on the executor's.

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <string>
#include <vector>

#include "server/access/access_witness.h"
#include "server/access/proof_ends.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/ports/alarm_condition.h"
#include "server/core/description/access_description.h"
#include "server/core/ports/clock.h"

namespace driftwise::application {

class AccessDesk final : public access::AccessWitness {
 public:
  // Between two looks at certificates and addresses, wall time.
  static constexpr double kLook_s = 60;

  // texts: the thread that reads the files. alarm: told of what happened and is over at once.
  AccessDesk(asio::any_io_executor executor, asio::any_io_executor texts,
             const AccessDescription& description, Clock& clock, EventLog& events, TaskGroup& tasks,
             std::function<void(AlarmCondition)> alarm);

  void note(access::AccessNote what) override;
  // Ends of clients' tokens and certificates are asked here, on the thread of the texts.
  // Before start(); what it asks outlives shut_down().
  void ask_for_ends(std::function<std::vector<access::EndingProof>()> ends);

  void start();  // looks at both until shut_down()
  void shut_down();
  // certificate.ends: 30 days ahead, by the wall clock; certificate.unusable: its files cannot be
  // read or do not belong together; certificate.revocations: the list of revoked ones likewise;
  // door.unreached: the computer does not have the address; access.ends: a client's token or
  // certificate, 30 days ahead.
  std::vector<AlarmCondition> conditions() const { return conditions_; }

 private:
  Awaitable<void> watch();
  void take(const access::AccessNote& what);

  asio::any_io_executor executor_, texts_;
  const AccessDescription& description_;
  Clock& clock_;
  EventLog& events_;
  TaskGroup& tasks_;
  std::function<void(AlarmCondition)> alarm_;
  std::function<std::vector<access::EndingProof>()> ends_;
  std::vector<AlarmCondition> conditions_;
  bool ending_ = false;
  Signal ended_;
};

}  // namespace driftwise::application
