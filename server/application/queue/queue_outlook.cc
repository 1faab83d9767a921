#include "server/application/queue/queue_outlook.h"

#include <algorithm>

#include "server/application/ports/run_plan.h"
#include "server/application/queue/queue_rule.h"

namespace driftwise::application {
namespace {

RunRules rules_of(const QueueEntry& entry, const RunRules& cell_rules) {
  if (entry.rules_json.empty() || !states_rules(entry.rules_json)) return cell_rules;
  const auto plan = read_run_plan(entry.rules_json);
  return plan ? plan->rules : cell_rules;
}

}  // namespace

std::map<QueueEntryId, EntryOutlook> look_ahead(const DurationHistory& history,
                                                const QueueAhead& queue) {
  std::map<QueueEntryId, EntryOutlook> all;
  std::vector<double> until_s;  // from now, of the one before, draw by draw
  bool known = !queue.held && !queue.stands;
  for (const auto& entry : *queue.entries) {
    if (entry.state != QueueState::running || !queue.under_way) continue;
    until_s = queue.under_way->draws_s;
    all[entry.id] = {*queue.under_way, queue.stands ? std::nullopt : queue.under_way};
  }
  // A run that nobody put into the queue goes first all the same.
  if (until_s.empty() && queue.under_way) until_s = queue.under_way->draws_s;
  for (const auto* entry : waiting_in_order(*queue.entries)) {
    const auto plan = queue.plans.find(entry->id);
    if (plan == queue.plans.end()) {
      known = false;
      continue;
    }
    RunAhead ahead;
    ahead.plan = plan->second;
    ahead.unit_s = planned_visit_s(rules_of(*entry, queue.rules));
    ahead.seed = static_cast<std::uint64_t>(entry->id.value);
    EntryOutlook outlook{look_ahead(history, ahead), {}};
    const auto* before = entry->after ? find_entry(*queue.entries, *entry->after) : nullptr;
    const bool may_come =
        !entry->after || (before && (before->accepted() || all.contains(before->id)));
    known = known && entry->condition.empty() && may_come;
    if (known) {
      const double not_before_s =
          entry->not_before.ns == 0 ? 0
                                    : seconds_from(queue.cell_time(entry->not_before) - queue.now);
      auto& draws_s = outlook.run.draws_s;
      until_s.resize(draws_s.size(), until_s.empty() ? 0 : until_s.back());
      for (std::size_t i = 0; i < draws_s.size(); ++i)
        until_s[i] = std::max(until_s[i], not_before_s) + draws_s[i];
      outlook.end = outlook.run;
      outlook.end->draws_s = until_s;
      take_figures(*outlook.end);
    }
    all[entry->id] = std::move(outlook);
  }
  return all;
}

}  // namespace driftwise::application
