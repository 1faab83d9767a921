#include "server/application/diagnoses/extensions_service.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/datasets/extension_preview.h"
#include "server/application/datasets/instruments.h"
#include "server/application/diagnoses/extension_fit.h"
#include "server/application/diagnoses/extension_plan.h"
#include "server/application/diagnoses/taken_side.h"
#include "server/application/models/fit_options.h"
#include "server/application/models/model_integrity.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/provenance/promotion_material.h"
#include "server/application/provenance/promotion_questions.h"
#include "server/compensation/snapshot_builder.h"
#include "server/core/reasons.h"
#include "server/core/records/state_text.h"
#include "server/core/try.h"
#include "server/diagnosis/report/sentence.h"
#include "server/formats/diagnosis/amendment_json.h"
#include "server/formats/diagnosis/stored_diagnosis.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

struct AcceptMaterial {  // read from the store
  DiagnosisRecord record;
  diagnosis::Diagnosis found;
  std::vector<int> chosen;
  std::string taken_as;
  RunsData data;
  Instruments instruments;                // of all the runs
  std::vector<CorrectionId> corrections;  // in force over them
  std::vector<std::string> changed;       // corrections of them, since they were diagnosed
  std::optional<ModelRecord> parent;
  PromotionMaterial of_runs;  // where the model is to serve
};

struct MadeExtension {  // by the worker
  ExtensionPlan plan;
  ModelRecord model;
  PromotionQuestions asked;  // before it is promoted
};

Result<AcceptMaterial> gather_to_accept(Store& store, const AcceptRequest& request,
                                        const CellDescription* present) {
  AcceptMaterial material;
  DRIFTWISE_TRY(auto record, store.diagnoses().diagnosis(request.diagnosis));
  material.record = std::move(record);
  if (material.record.state != JobState::done)
    return fail(ErrorCode::failed_precondition, reasons::kNotDone,
                fmt::format("diagnosis {} {}: only one that is done can be accepted",
                            material.record.id.value, is_text(material.record.state)));
  DRIFTWISE_TRY(auto found, formats::read_stored_diagnosis(material.record.result_json));
  material.found = std::move(found);
  DRIFTWISE_TRY(auto chosen, chosen_findings(material.found, request.findings));
  material.chosen = std::move(chosen);
  material.taken_as = request.findings.empty() ? "" : kAsNamed;  // chosen by a person
  if (material.record.runs.empty())
    return fail(ErrorCode::failed_precondition, reasons::kFromAFile,
                fmt::format("diagnosis {} is of a file, which the record does not keep: import it "
                            "('driftwise data import FILE'), diagnose that run and accept there",
                            material.record.id.value));
  DRIFTWISE_TRY(const auto standing, store.extensions().extension(material.record.id));
  if (standing && standing->stands())
    return fail(ErrorCode::already_exists, reasons::kExtensionStands,
                fmt::format("diagnosis {} was accepted by {} and stands: undo it first to accept "
                            "other findings",
                            material.record.id.value, standing->accepted_by));
  DRIFTWISE_TRY(auto data, amended_data(store, material.record.runs));
  material.data = std::move(data);
  DRIFTWISE_TRY(material.instruments, instruments_of(store, material.record.runs));
  DRIFTWISE_TRY(auto corrections, corrections_over(store, material.record.runs));
  material.corrections = std::move(corrections);
  DRIFTWISE_TRY(auto changed,
                corrections_since(store, material.record.runs, material.record.created));
  material.changed = std::move(changed);
  if (request.promote) {
    DRIFTWISE_TRY(auto of_runs, promotion_material(store, material.record.runs,
                                                   material.record.created, *present));
    material.of_runs = std::move(of_runs);
  }
  if (material.record.model) {
    DRIFTWISE_TRY(auto parent, store.models().model(*material.record.model));
    DRIFTWISE_RETURN_IF_ERROR(check_integrity(parent));
    material.parent = std::move(parent);
  }
  return material;
}

FitRequest fit_of(const AcceptMaterial& material, const ExtensionPlan& plan) {
  FitRequest fit;
  fit.runs = material.record.runs;
  fit.formula = plan.formula;
  fit.select = "all";
  if (material.parent) {
    fit.parent = material.parent->id;
    if (const auto parent = formats::read_model_json(material.parent->json)) {
      fit.select = parent->select;
      fit.criterion = parent->criterion;
      fit.p_enter = parent->p_enter;
      fit.p_remove = parent->p_remove;
      fit.hierarchy = parent->hierarchy;
    }
  }
  fit.note = fmt::format("from diagnosis {}", material.record.id.value);
  for (const int number : plan.findings) {
    const auto& finding = material.found.findings[static_cast<std::size_t>(number - 1)];
    fit.note += fmt::format("{} finding {}: {}", number == plan.findings.front() ? "," : ";",
                            number, finding.sentence);
  }
  return fit;
}

// A correction holds for every run only of one instrument, which is kept with it.
Result<void> name_instruments(const Instruments& instruments,
                              correction::DataAmendment& amendment) {
  for (auto& shift : amendment.shifts) {
    const auto by = instruments.find(shift.axis);
    if (!shift.runs.empty() || by == instruments.end()) continue;
    if (by->second.size() != 1)
      return fail(ErrorCode::failed_precondition, reasons::kUncertainCorrection,
                  fmt::format("{} of the diagnosed runs was measured by {}: whose error the "
                              "finding is, they do not tell. Diagnose runs of one of them",
                              shift.axis, fmt::join(by->second, " and ")));
    shift.device = by->second.front();
  }
  return {};
}

// A correction has the size that was found in the data of then. Laid over others that came since,
// it would take the same error off twice.
Result<ExtensionPlan> plan_of(const AcceptMaterial& material) {
  DRIFTWISE_TRY(auto plan, plan_extension(material.record.id, material.found, material.chosen,
                                          material.data, material.taken_as));
  DRIFTWISE_RETURN_IF_ERROR(name_instruments(material.instruments, plan.amendment));
  const auto& amendment = plan.amendment;
  const bool has_size = !amendment.shifts.empty() || !amendment.angles.empty();
  if (material.changed.empty() || !(has_size || !amendment.splits.empty())) return plan;
  return fail(
      ErrorCode::failed_precondition, reasons::kStale,
      fmt::format("since diagnosis {} was made, {}: what it found may be corrected already; "
                  "diagnose {} again and accept that",
                  material.record.id.value, fmt::join(material.changed, ", "),
                  material.record.runs.size() == 1 ? "the run" : "the runs"));
}

Result<MadeExtension> make_extension(AcceptMaterial material, bool promote,
                                     const CellDescription& cell, const Clock& clock) {
  DRIFTWISE_TRY(auto plan, plan_of(material));
  DRIFTWISE_RETURN_IF_ERROR(put_in_force(plan, material.data));
  DRIFTWISE_TRY(auto model, fit_extension(plan, material.data.data, fit_of(material, plan)));
  PromotionQuestions asked;
  if (promote) {  // whether it can serve is seen before anything is kept
    DRIFTWISE_TRY(auto whole, formats::read_model_json(model.json));
    asked = questions_before_serving(whole, material.of_runs, cell,
                                     [&clock](CellTime at) { return clock.utc(at); });
    DRIFTWISE_RETURN_IF_ERROR(
        compensation::SnapshotBuilder::create(std::move(whole), ModelId{}, cell));
  }
  return MadeExtension{std::move(plan), std::move(model), std::move(asked)};
}

// Without a fit where none is needed: what changes, and what a promotion would ask.
Result<MadeExtension> previewed(const AcceptMaterial& material, bool promote,
                                const CellDescription& cell, const Clock& clock) {
  if (promote) return make_extension(material, promote, cell, clock);
  DRIFTWISE_TRY(auto plan, plan_of(material));
  return MadeExtension{std::move(plan), {}, {}};
}

std::vector<std::string> sentences_of(const correction::DataAmendment& amendment) {
  std::vector<std::string> sentences;
  for (const auto& split : amendment.splits)
    sentences.push_back(
        fmt::format("the datum of run {} is split before row {}", split.run.value, split.row + 1));
  for (const auto& out : amendment.sensors)
    sentences.push_back(fmt::format("{} is left out of run {}", out.symbol, out.run.value));
  return sentences;
}

// " with laser-x": the instruments whose error it is, where they are known.
std::string with_instruments(const correction::DataAmendment& amendment) {
  std::vector<std::string> devices;
  for (const auto& shift : amendment.shifts)
    if (!shift.device.empty() && std::ranges::find(devices, shift.device) == devices.end())
      devices.push_back(shift.device);
  return devices.empty() ? "" : fmt::format(" with {}", fmt::join(devices, " or "));
}

// with: as with_instruments has it.
std::vector<std::string> sentences_of(const ExtensionPreview& preview, bool promote,
                                      const std::string& with, const Clock& clock) {
  constexpr std::size_t kMostNamed = 12;
  std::vector<std::string> sentences;
  sentences.push_back(fmt::format(
      "a model is fitted: {}{}", preview.formula,
      promote ? ", and serves targets at once" : ", which serves nobody until it is promoted"));
  std::size_t named = 0;
  for (const auto& change : preview.changes)
    if (named++ < kMostNamed) sentences.push_back("changes " + sentence(change, clock));
  if (named > kMostNamed)
    sentences.push_back(fmt::format("... and {} more lengths of runs", named - kMostNamed));
  if (preview.earlier_runs)
    sentences.push_back(
        "earlier runs too: every export, fit and check of the runs above sees the "
        "corrected lengths from now on; the stored points stay as they were");
  else if (!preview.changes.empty())
    sentences.push_back(
        "every export, fit and check of these runs sees the corrected lengths from "
        "now on; the stored points stay as they were");
  if (preview.later_runs)
    sentences.push_back("and so does every run that is measured later" + with);
  for (const auto& out : preview.excluded)
    sentences.push_back(fmt::format("{} row{} of run {} {} kept out of fits", out.rows.size(),
                                    out.rows.size() == 1 ? "" : "s", out.run.value,
                                    out.rows.size() == 1 ? "is" : "are"));
  sentences.insert(sentences.end(), preview.further.begin(), preview.further.end());
  return sentences;
}

// ", x_mm of run 3 by up to 40 nm": for the event.
std::string largest_of(const std::vector<LengthChange>& changes, const Clock& clock) {
  if (changes.empty()) return {};
  const auto& largest = *std::ranges::max_element(changes, {}, &LengthChange::largest_nm);
  return fmt::format(", changes {}{}", sentence(largest, clock),
                     changes.size() > 1 ? fmt::format(", and {} more", changes.size() - 1) : "");
}

std::string numbers_of(const std::vector<int>& findings) {
  return fmt::format("finding{} {}", findings.size() == 1 ? "" : "s", fmt::join(findings, ", "));
}

// served: "which serves", or once it is undone "which served".
std::string made_of(const ExtensionRecord& made, const char* served = "which serves") {
  std::string text;
  const auto say = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (made.model)
    say(fmt::format("model {}{}", made.model->value,
                    made.promoted ? fmt::format(", {}", served) : ""));
  if (made.correction) say(fmt::format("correction {}", made.correction->value));
  for (const auto& out : made.excluded)
    say(fmt::format("{} rows of run {} kept out", out.rows.size(), out.run.value));
  return text;
}

// The plan that was promoted last, where it serves with this model.
Result<std::optional<PlanId>> plan_with(Store& store, ModelId model) {
  DRIFTWISE_TRY(const auto history, store.plans().plan_promotions());
  if (history.empty() || !history.back().plan) return std::optional<PlanId>();
  DRIFTWISE_TRY(const auto plan, store.plans().plan(*history.back().plan));
  const bool has = std::ranges::any_of(plan.models, [&](auto& one) { return one.first == model; });
  return has ? std::optional(plan.id) : std::nullopt;
}

// Models of extensions that were undone, with that of the one that is being undone.
Result<std::vector<ModelId>> withdrawn_models(Store& store, DiagnosisId undoing) {
  DRIFTWISE_TRY(const auto newest, store.diagnoses().diagnoses(1));
  std::vector<ModelId> withdrawn, standing;
  const std::int64_t last = newest.empty() ? 0 : newest.front().id.value;
  for (std::int64_t number = 1; number <= last; ++number) {
    DRIFTWISE_TRY(const auto extension, store.extensions().extension(DiagnosisId{number}));
    if (!extension || !extension->model) continue;
    const bool stands = extension->stands() && number != undoing.value;
    (stands ? standing : withdrawn).push_back(*extension->model);
  }
  std::erase_if(withdrawn,
                [&](ModelId id) { return std::ranges::find(standing, id) != standing.end(); });
  return withdrawn;
}

}  // namespace

Awaitable<Result<ExtensionRecord>> ExtensionsService::accept(Caller caller, AcceptRequest request) {
  const auto changing_data = co_await changing_.lock();  // what is in force stays that to the end
  DRIFTWISE_CO_TRY(auto material, co_await reader_.call(gather_to_accept, request, &description_));
  auto shared = std::make_shared<AcceptMaterial>(std::move(material));
  DRIFTWISE_CO_TRY(auto made, co_await run_on(
                                  worker_,
                                  [promote = request.promote, cell = &description_,
                                   clock = &clock_](const std::shared_ptr<AcceptMaterial>& from) {
                                    return make_extension(*from, promote, *cell, *clock);
                                  },
                                  shared));

  if (request.promote && !request.confirmed)
    DRIFTWISE_CO_RETURN_IF_ERROR(confirmation_of(made.asked.all));
  if (request.reason.empty()) DRIFTWISE_CO_RETURN_IF_ERROR(reason_for(made.asked.for_a_reason));
  auto changing = changes_in_all_runs(made.plan.amendment, shared->record.runs);
  DRIFTWISE_CO_TRY(auto changes, co_await std::move(changing));

  made.model.created = clock_.now().utc;
  made.model.created_by = caller.name;
  made.model.corrections = shared->corrections;
  NewExtension fresh;
  fresh.diagnosis = request.diagnosis;
  fresh.findings = made.plan.findings;
  fresh.promoted = request.promote;
  fresh.fitted = made.model;
  fresh.rests_on_this = true;
  if (!made.plan.amendment.empty())
    fresh.correction_json = formats::write_amendment_json(made.plan.amendment);
  fresh.changes = std::move(changes);
  fresh.exclusions = made.plan.exclusions;
  fresh.at = clock_.now();
  fresh.who = caller.name;
  fresh.from = caller.peer;
  std::optional<AsyncMutex::Lock> serving_turn;
  if (request.promote) serving_turn.emplace(co_await promotions_.turn());
  auto stored = co_await writer_.extensions().accept(fresh);
  if (!stored) co_return stored;
  auto detail =
      fmt::format("{} accepted {} of diagnosis {}: {}{}", caller.name, numbers_of(stored->findings),
                  request.diagnosis.value, made_of(*stored), largest_of(fresh.changes, clock_));
  const auto before = serving_.model();
  events_.record(caller, "extension.accepted", std::move(detail), {},
                 {fmt::format("diagnosis {}", request.diagnosis.value), "", made_of(*stored)});
  if (stored->promoted) {
    // Its promotion is in the record already, and the worker has seen that it can serve.
    DRIFTWISE_CO_TRY(auto record, co_await models_.get(*stored->model));
    auto serving = serving_.serve(record);
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(serving));
    promotions_.announce(caller, std::move(record), "promote", before);
    if (!request.reason.empty())
      DRIFTWISE_CO_RETURN_IF_ERROR(
          co_await promotions_.keep_reason(caller, *stored->model, request.reason));
  }
  co_return stored;
}

Awaitable<Result<ExtensionPreview>> ExtensionsService::preview(AcceptRequest request) {
  DRIFTWISE_CO_TRY(auto material, co_await reader_.call(gather_to_accept, request, &description_));
  const auto shared = std::make_shared<AcceptMaterial>(std::move(material));
  DRIFTWISE_CO_TRY(auto made, co_await run_on(
                                  worker_,
                                  [promote = request.promote, cell = &description_,
                                   clock = &clock_](const std::shared_ptr<AcceptMaterial>& from) {
                                    return previewed(*from, promote, *cell, *clock);
                                  },
                                  shared));
  const auto& plan = made.plan;
  auto changing = changes_in_all_runs(plan.amendment, shared->record.runs);
  DRIFTWISE_CO_TRY(auto changes, co_await std::move(changing));
  ExtensionPreview preview;
  preview.findings = plan.findings;
  preview.formula = plan.formula;
  preview.extends_model = plan.extends_model;
  preview.changes = std::move(changes);
  preview.earlier_runs = std::ranges::any_of(
      preview.changes, [](const LengthChange& change) { return !change.diagnosed; });
  preview.later_runs = concerns_every_run(plan.amendment);
  for (const auto& out : plan.exclusions) preview.excluded.push_back({out.run, out.rows});
  preview.further = sentences_of(plan.amendment);
  if (!plan.amendment.shifts.empty() &&
      std::ranges::any_of(shared->data.origins, &correction::RowOrigin::of_file))
    preview.further.push_back(
        "the rows diagnosed are a file's, of instruments that this cell does not know: the "
        "correction holds for these runs alone, and for no run that this cell measured or will "
        "measure");
  for (const int number : plan.findings)
    if (auto note =
            diagnosis::aliases_note(shared->found.findings[static_cast<std::size_t>(number - 1)]);
        !note.empty())
      preview.further.push_back(
          fmt::format("finding {}: {}: where the period is another, what is accepted is wrong "
                      "everywhere else",
                      number, note));
  preview.promotion_questions = made.asked.all;
  preview.questions_for_a_reason = made.asked.for_a_reason;
  preview.sentences =
      sentences_of(preview, request.promote, with_instruments(plan.amendment), clock_);
  co_return preview;
}

// Every run in the record, one call of the reader each: others have their turn in between.
Awaitable<Result<std::vector<LengthChange>>> ExtensionsService::changes_in_all_runs(
    correction::DataAmendment amendment, std::vector<RunId> diagnosed) {
  std::vector<LengthChange> all;
  if (amendment.shifts.empty()) co_return all;
  constexpr int kPage = 1000;
  for (std::int64_t before = 0;;) {
    DRIFTWISE_CO_TRY(const auto page, co_await reader_.runs().runs(kPage, before));
    for (const auto& run : page) {
      if (run.accepted == 0 || !concerns(amendment, run)) continue;
      DRIFTWISE_CO_TRY(auto changes, co_await reader_.call(length_changes, run.id, amendment));
      for (auto& change : changes) {
        change.run_name = run.name;
        change.diagnosed = std::ranges::find(diagnosed, run.id) != diagnosed.end();
        all.push_back(std::move(change));
      }
    }
    if (static_cast<int>(page.size()) < kPage) break;
    before = page.back().id.value;
  }
  std::ranges::stable_sort(all, [](const LengthChange& a, const LengthChange& b) {
    return a.diagnosed != b.diagnosed ? a.diagnosed : a.largest_nm > b.largest_nm;
  });
  co_return all;
}

Awaitable<Result<ExtensionRecord>> ExtensionsService::undo(Caller caller, DiagnosisId id) {
  // Where its model serves, whoever promoted it, the one before serves again that is not undone
  // itself. In the same transaction.
  const auto changing_data = co_await changing_.lock();
  const auto serving_turn = co_await promotions_.turn();
  std::optional<PromotionRecord> rollback;
  std::optional<ModelRecord> previous, present;
  DRIFTWISE_CO_TRY(const auto view, co_await diagnoses_.get(id));
  const bool has_model = view.extension && view.extension->stands() && view.extension->model;
  if (has_model) {
    DRIFTWISE_CO_TRY(const auto plan, co_await reader_.call(plan_with, *view.extension->model));
    if (plan)
      co_return fail(
          ErrorCode::failed_precondition, reasons::kExtensionStands,
          fmt::format("plan {} serves with model {} of diagnosis {}: promote a plan without it "
                      "('driftwise plan promote'), or take the plan back ('driftwise plan "
                      "rollback'), then undo",
                      plan->value, view.extension->model->value, id.value));
  }
  if (has_model && serving_.model() == view.extension->model) {
    DRIFTWISE_CO_TRY(auto withdrawn, co_await reader_.call(withdrawn_models, id));
    auto finding = promotions_.served_before(std::move(withdrawn));
    DRIFTWISE_CO_TRY(auto before, co_await std::move(finding));
    previous = std::move(before);
    auto reading = models_.get(*view.extension->model);
    DRIFTWISE_CO_TRY(auto record, co_await std::move(reading));
    present = std::move(record);
    rollback = PromotionRecord{previous ? std::optional(previous->id) : std::nullopt,
                               clock_.now().utc, caller.name, "rollback"};
    auto serving = serving_.serve(previous);  // first see that it can serve
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(serving));
  }
  auto undone = co_await writer_.extensions().undo_extension(id, clock_.now(), caller.name,
                                                             caller.peer, rollback);
  if (!undone) {
    if (rollback) {
      auto again = serving_.serve(present);
      static_cast<void>(co_await std::move(again));
    }
    co_return undone;
  }
  auto detail =
      fmt::format("{} undid {} of diagnosis {}: {} no longer in force", caller.name,
                  numbers_of(undone->findings), id.value, made_of(*undone, "which served"));
  events_.record(caller, "extension.undone", std::move(detail), {},
                 {fmt::format("diagnosis {}", id.value), made_of(*undone), ""});
  if (rollback)
    promotions_.announce(caller, std::move(previous), "rollback",
                         present ? std::optional(present->id) : std::nullopt);
  co_return undone;
}

}  // namespace driftwise::application
