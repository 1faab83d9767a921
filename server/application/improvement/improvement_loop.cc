#include "server/application/improvement/improvement_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "server/application/improvement/fresh_points.h"
#include "server/application/improvement/fresh_verdict.h"
#include "server/application/models/model_integrity.h"
#include "server/core/reasons.h"
#include "server/core/records/state_text.h"
#include "server/core/try.h"
#include "server/diagnosis/report/heading.h"
#include "server/formats/csv/trajectory_csv.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

constexpr auto kLease = std::chrono::minutes(30);
constexpr auto kRenewEvery = std::chrono::minutes(5);

std::vector<TurnGain> promised_gains(const diagnosis::Diagnosis& found) {
  std::vector<TurnGain> gains;
  for (const auto& judged : diagnosis::judged_accuracies(found))
    gains.push_back({judged.output, judged.unit, judged.before.value_or(judged.figures),
                     judged.figures, std::nullopt, std::nullopt});
  return gains;
}

std::string name_of(const diagnosis::Finding& finding) {
  return finding.cause + (finding.subject.empty() ? "" : " " + finding.subject);
}

// Those that stand for themselves, and a sentence about those that do not.
struct Choice {
  std::vector<int> findings;
  std::string undecided;
};
Choice what_can_be_told(const diagnosis::Diagnosis& found) {
  Choice choice;
  int number = 0;
  for (const auto& finding : found.findings) {
    ++number;
    if (finding.indistinguishable_from.empty())
      choice.findings.push_back(number);
    else
      choice.undecided +=
          fmt::format("{}{} cannot be told apart from {}", choice.undecided.empty() ? "" : "; ",
                      name_of(finding), fmt::join(finding.indistinguishable_from, ", "));
  }
  return choice;
}

Reach farthest_of(const diagnosis::Diagnosis& found, const std::vector<int>& numbers) {
  Reach reach = Reach::marks;
  for (const int number : numbers)
    reach = std::max(reach, reach_of(found.findings[static_cast<std::size_t>(number - 1)]));
  return reach;
}

std::string turns_made(int count) {
  return count == 1 ? "one turn was made" : fmt::format("{} turns were made", count);
}

}  // namespace

ImprovementLoop::ImprovementLoop(asio::any_io_executor executor, ImprovementServices services,
                                 Clock& clock, Caller caller, ImproveRequest request,
                                 ImprovementId id, Hooks hooks)
    : services_(services),
      clock_(clock),
      caller_(std::move(caller)),
      request_(std::move(request)),
      id_(id),
      hooks_(std::move(hooks)),
      wake_(executor) {}

Awaitable<Result<std::string>> ImprovementLoop::carry_out() {
  began_ = clock_.now().utc;
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await begin());
  while (true) {
    const auto after = co_await take_turn();
    auto withdrawing = withdraw();
    const std::string withdrawn = co_await std::move(withdrawing);
    if (!after) say("stopped: " + after.error().message);
    if (!withdrawn.empty()) say(withdrawn);
    if (!after) {
      static_cast<void>(co_await keep());
      co_return tl::unexpected(after.error());
    }
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await keep());
    if (*after == After::end) co_return reason_;
    if (turn_.number >= request_.max_turns) {
      co_return turns_made(turn_.number);
    }
    const int next = turn_.number + 1;
    turn_ = {};
    turn_.number = next;
    turn_.started = clock_.now().utc;
    // A start after a kill undoes what the last turn on record accepted without proof: from here on
    // that is not the turn before.
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await keep());
  }
}

Awaitable<std::string> ImprovementLoop::withdraw() {
  while (withdrawing_) co_await wake_.wait();
  if (!unproved_) co_return withdrawn_;
  withdrawing_ = true;
  auto undoing = undo_unproved(*std::exchange(unproved_, std::nullopt));
  withdrawn_ = co_await std::move(undoing);
  withdrawing_ = false;
  wake_.raise();
  co_return withdrawn_;
}

Awaitable<std::string> ImprovementLoop::undo_unproved(ExtensionRecord extension) {
  const auto id = extension.diagnosis.value;
  if (extension.model && services_.serving.model() == extension.model)
    co_return fmt::format("diagnosis {} stays in force without proof, for its model serves", id);
  auto undoing = services_.extensions.undo(caller_, extension.diagnosis);
  const auto undone = co_await std::move(undoing);
  if (undone) co_return fmt::format("diagnosis {} was undone: no fresh points show its gain", id);
  if (undone.error().reason == reasons::kNoExtension) co_return std::string();  // by a person
  co_return fmt::format(
      "diagnosis {} stays in force without proof ({}): 'driftwise diagnosis undo {}'", id,
      undone.error().message, id);
}

// What is known before the robot moves.
Awaitable<Result<void>> ImprovementLoop::begin() {
  turn_.started = began_;
  auto checking = services_.trajectories.check("trajectory", request_.trajectory_text);
  DRIFTWISE_CO_TRY(auto check, co_await std::move(checking));
  plan_ = std::move(check.trajectory);
  estimated_s_ = check.estimated_s;
  if (!request_.formula.empty()) {
    formula_ = request_.formula;
    co_return Result<void>{};
  }
  model_ = services_.serving.model();
  if (!model_)
    co_return fail(ErrorCode::failed_precondition, reasons::kNoModel,
                   "no formula is given and no model serves: give the first model's formula");
  DRIFTWISE_CO_TRY(const auto record, co_await services_.models.get(*model_));
  DRIFTWISE_CO_TRY(const auto model, read_formula_model(record, "improvements begin"));
  formula_ = model.formula;
  co_return Result<void>{};
}

Awaitable<Result<ImprovementLoop::After>> ImprovementLoop::take_turn() {
  if (runs_.empty()) {
    auto measuring =
        measure(fmt::format("measuring {} points", plan_.points.size()), text_of_repeat(0));
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(measuring));
  }
  if (!model_) {
    hooks_.tell(turn_.number, "fitting the first model");
    FitRequest fit;
    fit.runs = runs_;
    fit.formula = formula_;
    fit.note = fmt::format("of improvement {}", id_.value);
    auto fitting = services_.models.fit(caller_, std::move(fit));
    DRIFTWISE_CO_TRY(const auto model, co_await std::move(fitting));
    model_ = model.id;
    turn_.model = model_;
    say(fmt::format("fitted model {}: {}", model.id.value, formula_));
  }
  auto view = co_await diagnose();
  DRIFTWISE_CO_RETURN_IF_ERROR(view);
  auto separated = separate(std::move(*view));
  view = co_await std::move(separated);
  DRIFTWISE_CO_RETURN_IF_ERROR(view);
  const auto& found = *view->found;
  const auto choice = what_can_be_told(found);
  if (!choice.findings.empty()) co_return co_await extend(*view, choice.findings);
  if (!choice.undecided.empty())
    reason_ = choice.undecided + (found.separating_experiment
                                      ? ": " + found.separating_experiment->why
                                      : ": no measurement that separates them is known");
  else if (found.left_over.empty())
    reason_ = "nothing beyond noise is left";
  else
    reason_ = fmt::format(
        "structure is left that no cause of the catalogue explains; it goes with "
        "{}",
        found.left_over.front().goes_with);
  say(reason_);
  co_return After::end;
}

// Lease of the whole improvement: kept while a diagnosis takes longer than a lease lasts. One that
// was given up is not taken again, and the next measurement is refused.
void ImprovementLoop::renew_lease() {
  static_cast<void>(services_.manual.take_lease(caller_, kLease, request_.lease_token));
}

CellTime ImprovementLoop::next_renewal() const {
  return clock_.now().utc + std::chrono::duration_cast<Nanoseconds>(kRenewEvery);
}

Awaitable<Result<DiagnosisView>> ImprovementLoop::diagnose() {
  DRIFTWISE_CO_RETURN_IF_ERROR(check());
  hooks_.tell(turn_.number, "diagnosing");
  DiagnosisRequest wanted;
  wanted.runs = runs_;
  wanted.baseline = formula_;
  wanted.model = model_;
  wanted.name = fmt::format("improvement {}, turn {}", id_.value, turn_.number);
  auto creating = services_.diagnoses.create(caller_, std::move(wanted));
  DRIFTWISE_CO_TRY(const auto created, co_await std::move(creating));
  diagnosis_ = turn_.diagnosis = created.record.id;
  if (stopping_) co_await end_own_jobs();
  bool over = false;
  const auto watch = services_.diagnoses.watch([&](const DiagnosisProgress& progress) {
    if (progress.id != diagnosis_) return;
    over = progress.state != JobState::running;
    if (over)
      wake_.raise();
    else
      hooks_.tell(turn_.number, "diagnosing: " + progress.step);
  });
  auto view = co_await services_.diagnoses.get(created.record.id);
  while (view && view->record.state == JobState::running && !stopping_) {
    renew_lease();
    // Said once, looked at once: a record that is behind what was said is no reason to spin.
    if (!std::exchange(over, false)) co_await sleep_unless(clock_, next_renewal(), wake_);
    view = co_await services_.diagnoses.get(created.record.id);
  }
  diagnosis_.reset();
  if (!view) co_return view;
  DRIFTWISE_CO_RETURN_IF_ERROR(check());
  if (view->record.state != JobState::done || !view->found)
    co_return fail(ErrorCode::failed_precondition, reasons::kDiagnosisFailed,
                   fmt::format("diagnosis {} {}: {}", view->record.id.value,
                               is_text(view->record.state), view->record.reason));
  co_return view;
}

// Where nothing but the measurement can tell: it is made, and looked at together with the rest.
Awaitable<Result<DiagnosisView>> ImprovementLoop::separate(DiagnosisView view) {
  const auto experiment = view.found->separating_experiment;
  const auto choice = what_can_be_told(*view.found);
  if (choice.undecided.empty() || !experiment || experiment->trajectory_csv.empty()) co_return view;
  if (!has_time_for(experiment->estimated_s)) {
    say("the budget of time does not hold the separating measurement");
    co_return view;
  }
  say(fmt::format("{}: measured what separates them", choice.undecided));
  auto measuring =
      measure("measuring what separates " + choice.undecided, experiment->trajectory_csv);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(measuring));
  co_return co_await diagnose();
}

Awaitable<Result<ImprovementLoop::After>> ImprovementLoop::extend(const DiagnosisView& view,
                                                                  std::vector<int> findings) {
  DRIFTWISE_CO_RETURN_IF_ERROR(check());
  hooks_.tell(turn_.number, "extending");
  auto choosing = acceptable(view, std::move(findings));
  findings = co_await std::move(choosing);
  if (findings.empty()) {
    reason_ = turn_.what;  // why each of them is refused
    co_return After::end;
  }
  for (const int number : findings)
    say(view.found->findings[static_cast<std::size_t>(number - 1)].sentence);
  turn_.gains = promised_gains(*view.found);
  // A later start finds by it what was accepted.
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await keep());
  const Reach reach = farthest_of(*view.found, findings);
  if (reach != Reach::marks && !has_time_for(estimated_s_)) {
    reason_ = fmt::format(
        "the budget of {:g} s does not hold another measurement of {:.0f} s, which would show the "
        "gain of diagnosis {}: nothing of it was accepted",
        request_.budget_s, estimated_s_, view.record.id.value);
    say(reason_);
    co_return After::end;
  }
  DRIFTWISE_CO_RETURN_IF_ERROR(check());  // cancelled during the previews: nothing is accepted
  AcceptRequest wanted;
  wanted.diagnosis = view.record.id;
  wanted.findings = findings;
  auto accepting = services_.extensions.accept(caller_, std::move(wanted));
  DRIFTWISE_CO_TRY(const auto extension, co_await std::move(accepting));
  unproved_ = extension;
  if (extension.model) {
    DRIFTWISE_CO_TRY(const auto record, co_await services_.models.get(*extension.model));
    DRIFTWISE_CO_TRY(const auto model, formats::read_model_json(record.json));
    formula_ = model.formula;
    turn_.model = extension.model;
  }
  if (reach == Reach::marks) co_return co_await keep_unjudged(extension);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await keep());
  co_return co_await measure_again(extension, reach);
}

// Marks on readings of these runs: fresh points hold nothing of them, so none are measured. The
// next turn looks at the readings without what is marked.
Awaitable<Result<ImprovementLoop::After>> ImprovementLoop::keep_unjudged(
    const ExtensionRecord& extension) {
  DRIFTWISE_CO_RETURN_IF_ERROR(check());  // cancelled while it was accepted: it is withdrawn
  unproved_.reset();
  if (extension.model) model_ = extension.model;
  say(
      fmt::format("diagnosis {} stays: it marks readings of these runs, which fresh points cannot "
                  "judge",
                  extension.diagnosis.value));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await keep());
  co_return After::next_turn;
}

// Those that would be accepted each by itself; why not, of the others, is said.
Awaitable<std::vector<int>> ImprovementLoop::acceptable(const DiagnosisView& view,
                                                        std::vector<int> findings) {
  std::vector<int> kept;
  for (const int number : findings) {
    AcceptRequest alone;
    alone.diagnosis = view.record.id;
    alone.findings = {number};
    auto looking = services_.extensions.preview(std::move(alone));
    const auto preview = co_await std::move(looking);
    if (preview)
      kept.push_back(number);
    else
      say("not accepted: " + preview.error().message);
  }
  co_return kept;
}

Awaitable<Result<ImprovementLoop::After>> ImprovementLoop::measure_again(ExtensionRecord extension,
                                                                         Reach reach) {
  const auto before = model_;
  model_ = extension.model;
  ++repeats_;
  auto measuring = measure(fmt::format("measuring {} fresh points", plan_.points.size()),
                           text_of_repeat(repeats_));
  DRIFTWISE_CO_TRY(const auto run, co_await std::move(measuring));
  if (!before || !model_) {
    unproved_.reset();
    say(fmt::format("measured again, run {}", run.id.value));
    co_return After::next_turn;
  }
  DRIFTWISE_CO_TRY(const auto by_before, co_await errors_on(*before, run.id, extension.correction));
  DRIFTWISE_CO_TRY(const auto by_after, co_await errors_on(*model_, run.id, {}));
  DRIFTWISE_CO_RETURN_IF_ERROR(check());
  for (auto& gain : turn_.gains) {
    gain.measured_before = fresh_figures(by_before, gain.output);
    gain.measured = fresh_figures(by_after, gain.output);
  }
  const FreshVerdict verdict = judge_fresh(turn_.gains);
  if (verdict.judged)
    say(fmt::format("A90 on fresh points, run {}, by the model before and by the new one: {}",
                    run.id.value, verdict.measured));
  const bool acts_on_fresh = reach == Reach::every_run;
  if (verdict.judged && verdict.worse.empty() && (verdict.better || !acts_on_fresh)) {
    unproved_.reset();
    if (!verdict.better)
      say(
          fmt::format("diagnosis {} stays: it acts on its own runs only, and fresh points are no "
                      "worse with the model from them",
                      extension.diagnosis.value));
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await keep());
    if (verdict.better) co_await promote_proven();
    co_return After::next_turn;
  }
  auto undoing = services_.extensions.undo(caller_, extension.diagnosis);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(undoing));
  unproved_.reset();
  const auto undone = fmt::format("diagnosis {}: it was undone", extension.diagnosis.value);
  if (!verdict.judged)
    reason_ = "fresh points cannot judge the gain (" + why_unjudged(by_after) + ") of " + undone;
  else if (verdict.worse.empty())
    reason_ = fmt::format("fresh points do not show the gain of {}", undone);
  else
    reason_ = fmt::format("fresh points are worse with it, {}: {}", verdict.worse, undone);
  say(reason_);
  co_return After::end;
}

// A question that only a person can answer leaves the model proposed.
Awaitable<void> ImprovementLoop::promote_proven() {
  if (!request_.promotes || !model_) co_return;
  auto promoting = services_.promotions.promote(caller_, *model_);
  const auto promoted = co_await std::move(promoting);
  say(promoted
          ? fmt::format("promoted model {}", model_->value)
          : fmt::format("model {} was not promoted: {}", model_->value, promoted.error().message));
}

// A model's errors on a run that it was not fitted from, as a check standard has them: counted from
// the run's own zero, so that their mean counts. Each model answers for what the instruments read,
// its own corrections of them included: a correction proves nothing by being in the readings.
Awaitable<Result<ModelCheck>> ImprovementLoop::errors_on(ModelId model, RunId run,
                                                         std::optional<CorrectionId> leaving_out) {
  auto checking = services_.checks.check_model(model, {run}, leaving_out);
  co_return co_await std::move(checking);
}

Awaitable<Result<RunRecord>> ImprovementLoop::measure(std::string what,
                                                      std::string trajectory_text) {
  DRIFTWISE_CO_RETURN_IF_ERROR(check());
  hooks_.tell(turn_.number, what);
  CreateRun wanted;
  wanted.name = fmt::format("improvement {}, turn {}", id_.value, turn_.number);
  wanted.trajectory_name = request_.trajectory_name;
  wanted.setup = request_.setup;
  wanted.trajectory_text = std::move(trajectory_text);
  wanted.lease_token = request_.lease_token;
  renew_lease();
  auto creating = services_.runs.create(caller_, std::move(wanted));
  auto run = co_await std::move(creating);
  if (!run) co_return run;
  run_ = run->id;
  turn_.runs.push_back(run->id);
  if (stopping_) co_await end_own_jobs();  // it ended while the trajectory was read
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await keep());
  std::optional<RunRecord> ended;
  const auto watch = services_.runs.watch([&](const RunProgress& progress) {
    if (progress.run.id != run_) return;
    hooks_.tell(turn_.number,
                fmt::format("{}: {} of {}, {}", what, progress.run.accepted, progress.run.rows,
                            progress.run.state == RunState::running
                                ? progress.phase
                                : std::string(to_string(progress.run.state))));
    if (is_over(progress.run.state)) ended = progress.run;
    wake_.raise();
  });
  while (!ended && !stopping_) {  // a run that waits or is paused needs the lease as well
    renew_lease();
    const auto until = next_renewal();
    while (!ended && !stopping_ && clock_.now().utc < until)
      co_await sleep_unless(clock_, until, wake_);
  }
  run_.reset();
  DRIFTWISE_CO_RETURN_IF_ERROR(check());
  if (ended->state != RunState::done)
    co_return fail(
        ErrorCode::aborted, reasons::kRunEndedEarly,
        fmt::format("run {} {}: {}", ended->id.value, is_text(ended->state), ended->reason));
  runs_.push_back(ended->id);
  co_return *ended;
}

Awaitable<void> ImprovementLoop::stop(bool leave_run) {
  stopping_ = true;
  leave_run_ = leave_run;
  wake_.raise();
  co_await end_own_jobs();
}

Awaitable<void> ImprovementLoop::end_own_jobs() {
  if (diagnosis_) {
    auto cancelling = services_.diagnoses.cancel(caller_, *diagnosis_);
    static_cast<void>(co_await std::move(cancelling));
  }
  if (run_ && !leave_run_) {
    auto aborting = services_.runs.abort(caller_, *run_, "its improvement was cancelled");
    static_cast<void>(co_await std::move(aborting));
  }
}

Awaitable<Result<void>> ImprovementLoop::keep() {
  turn_.ended = clock_.now().utc;
  co_return co_await hooks_.keep(turn_);
}

void ImprovementLoop::say(const std::string& sentence) {
  // A finding's sentence ends with its own full stop.
  if (!turn_.what.empty()) turn_.what += turn_.what.ends_with('.') ? " " : ". ";
  turn_.what += sentence;
}

bool ImprovementLoop::has_time_for(double seconds) const {
  return request_.budget_s <= 0 ||
         seconds_from(clock_.now().utc - began_) + seconds <= request_.budget_s;
}

Result<void> ImprovementLoop::check() const {
  if (stopping_)
    return fail(ErrorCode::cancelled, reasons::kStopped, "the improvement was stopped");
  return {};
}

std::string ImprovementLoop::text_of_repeat(int repeat) const {
  return repeat == 0 ? request_.trajectory_text
                     : formats::write_trajectory_csv(fresh_points(plan_, repeat));
}

}  // namespace driftwise::application
