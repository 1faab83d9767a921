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

Outlook without_draws(const Outlook& outlook) {
  return {outlook.expected_s, outlook.low_s, outlook.high_s, outlook.runs, outlook.rows, {}};
}

}  // namespace

RunAhead run_ahead(const QueueEntry& entry, const PlanAhead& plan, const RunRules& cell_rules) {
  RunAhead ahead;
  ahead.plan = plan;
  ahead.unit_s = planned_visit_s(rules_of(entry, cell_rules));
  ahead.seed = static_cast<std::uint64_t>(entry.id.value);
  return ahead;
}

std::map<QueueEntryId, EntryOutlook> look_ahead(const QueueAhead& queue) {
  std::map<QueueEntryId, EntryOutlook> all;
  std::vector<double> until_s;  // from now, of the one before, draw by draw
  bool known = !queue.held && !queue.stands;
  for (const auto& entry : *queue.entries) {
    if (entry.state != QueueState::running || !queue.under_way) continue;
    const auto outlook = without_draws(*queue.under_way);
    all[entry.id] = {outlook, queue.stands ? std::nullopt : std::optional(outlook)};
  }
  // A run that nobody put into the queue goes first all the same.
  if (queue.under_way) until_s = queue.under_way->draws_s;
  for (const auto* entry : waiting_in_order(*queue.entries)) {
    if (queue.only && all.contains(*queue.only)) break;
    const auto length = queue.lengths->find(entry->id);
    if (length == queue.lengths->end() || !length->second.history) {
      known = false;
      continue;
    }
    const Outlook& run = length->second.run;
    EntryOutlook outlook{without_draws(run), {}};
    const auto* before = entry->after ? find_entry(*queue.entries, *entry->after) : nullptr;
    const bool may_come =
        !entry->after || (before && (before->accepted() || all.contains(before->id)));
    known = known && entry->condition.empty() && may_come;
    if (known) {
      const double not_before_s =
          entry->not_before.ns == 0 ? 0
                                    : seconds_from(queue.cell_time(entry->not_before) - queue.now);
      until_s.resize(run.draws_s.size(), until_s.empty() ? 0 : until_s.back());
      for (std::size_t i = 0; i < until_s.size(); ++i)
        until_s[i] = std::max(until_s[i], not_before_s) + run.draws_s[i];
      if (!queue.only || *queue.only == entry->id) {
        Outlook end = outlook.run;
        end.draws_s = until_s;
        take_figures(end);
        outlook.end = without_draws(end);
      }
    }
    all[entry->id] = std::move(outlook);
  }
  return all;
}

}  // namespace driftwise::application
