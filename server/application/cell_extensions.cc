// What is made of a diagnosis: accepted, undone.

#include <fmt/format.h>

#include "server/application/cell_application.h"
#include "server/application/extension_plan.h"
#include "server/application/fit_options.h"
#include "server/application/model_integrity.h"
#include "server/compensation/snapshot_builder.h"
#include "server/formats/amendment_json.h"
#include "server/formats/model_json.h"
#include "server/formats/stored_diagnosis.h"

namespace driftwise::application {
namespace {

struct AcceptMaterial {  // read from the store
  DiagnosisRecord record;
  diagnosis::Diagnosis found;
  std::vector<int> chosen;
  RunsData data;
  std::optional<ModelRecord> parent;
};

struct MadeExtension {  // by the worker
  ExtensionPlan plan;
  ModelRecord model;
};

Result<AcceptMaterial> gather_to_accept(Store& store, const AcceptRequest& request) {
  AcceptMaterial material;
  auto record = store.diagnoses().diagnosis(request.diagnosis);
  if (!record) return tl::unexpected(record.error());
  material.record = std::move(*record);
  if (material.record.state != JobState::done)
    return fail(ErrorCode::failed_precondition, "NOT_DONE",
                fmt::format("diagnosis {} is {}: only one that is done can be accepted",
                            material.record.id.value, to_string(material.record.state)));
  auto found = formats::read_stored_diagnosis(material.record.result_json);
  if (!found) return tl::unexpected(found.error());
  material.found = std::move(*found);
  auto chosen = chosen_findings(material.found, request.findings);
  if (!chosen) return tl::unexpected(chosen.error());
  material.chosen = std::move(*chosen);
  if (material.record.runs.empty())
    return fail(ErrorCode::failed_precondition, "FROM_A_FILE",
                fmt::format("diagnosis {} is of a file, which the record does not keep: import it "
                            "('driftwise data import FILE'), diagnose that run and accept there",
                            material.record.id.value));
  const auto standing = store.diagnoses().extension(material.record.id);
  if (!standing) return tl::unexpected(standing.error());
  if (*standing && (*standing)->stands())
    return fail(ErrorCode::already_exists, "EXTENSION_STANDS",
                fmt::format("diagnosis {} was accepted by {} and stands: undo it first to accept "
                            "other findings",
                            material.record.id.value, (*standing)->accepted_by));
  auto data = amended_data(store, material.record.runs);
  if (!data) return tl::unexpected(data.error());
  material.data = std::move(*data);
  if (material.record.model) {
    auto parent = store.models().model(*material.record.model);
    if (!parent) return tl::unexpected(parent.error());
    if (auto whole = check_integrity(*parent); !whole) return tl::unexpected(whole.error());
    material.parent = std::move(*parent);
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

Result<MadeExtension> make_extension(AcceptMaterial material, bool promote,
                                     const CellDescription& cell) {
  auto plan = plan_extension(material.record.id, material.found, material.chosen, material.data);
  if (!plan) return tl::unexpected(plan.error());
  if (auto ok = put_in_force(*plan, material.data); !ok) return tl::unexpected(ok.error());
  auto fit = fit_of(material, *plan);
  auto model = fit_record(material.data.data, fit, source_of(fit));
  // A baseline may name terms that these data cannot hold apart: the selection takes what they can.
  if (!model && model.error().reason == "RANK_DEFICIENT") {
    fit.select = "stepwise";
    model = fit_record(material.data.data, fit, source_of(fit));
  }
  if (!model) return tl::unexpected(model.error());
  if (promote) {  // whether it can serve is seen before anything is kept
    auto whole = formats::read_model_json(model->json);
    if (!whole) return tl::unexpected(whole.error());
    const auto builder = compensation::SnapshotBuilder::create(std::move(*whole), ModelId{}, cell);
    if (!builder) return tl::unexpected(builder.error());
  }
  return MadeExtension{std::move(*plan), std::move(*model)};
}

std::string numbers_of(const std::vector<int>& findings) {
  return fmt::format("finding{} {}", findings.size() == 1 ? "" : "s", fmt::join(findings, ", "));
}

std::string made_of(const ExtensionRecord& made) {
  std::string text;
  const auto say = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (made.model)
    say(fmt::format("model {}{}", made.model->value, made.promoted ? ", which serves" : ""));
  if (made.correction) say(fmt::format("correction {}", made.correction->value));
  for (const auto& out : made.excluded)
    say(fmt::format("{} rows of run {} kept out", out.rows.size(), out.run.value));
  return text;
}

}  // namespace

Awaitable<Result<ExtensionRecord>> CellApplication::accept_extension(Caller caller,
                                                                     AcceptRequest request) {
  auto gathering =
      reader_.call([request](Store& store) { return gather_to_accept(store, request); });
  auto material = co_await std::move(gathering);
  if (!material) co_return tl::unexpected(material.error());
  auto shared = std::make_shared<AcceptMaterial>(std::move(*material));
  auto making =
      run_on(worker_thread_.executor(), [shared, promote = request.promote, cell = &description_] {
        return make_extension(std::move(*shared), promote, *cell);
      });
  auto made = co_await std::move(making);
  if (!made) co_return tl::unexpected(made.error());

  made->model.created = clock_->now().utc;
  made->model.created_by = caller.name;
  NewExtension fresh;
  fresh.diagnosis = request.diagnosis;
  fresh.findings = made->plan.findings;
  fresh.promoted = request.promote;
  if (!made->plan.amendment.empty())
    fresh.correction_json = formats::write_amendment_json(made->plan.amendment);
  fresh.exclusions = made->plan.exclusions;
  fresh.at = clock_->now();
  fresh.who = caller.name;
  fresh.from = caller.peer;
  auto storing =
      writer_.call([fresh, model = made->model](Store& store) mutable -> Result<ExtensionRecord> {
        const auto id = store.models().add_model(model);
        if (!id) return tl::unexpected(id.error());
        fresh.model = *id;
        return store.diagnoses().accept(fresh);
      });
  auto stored = co_await std::move(storing);
  if (!stored) co_return stored;
  auto detail =
      fmt::format("{} accepted {} of diagnosis {}: {}", caller.name, numbers_of(stored->findings),
                  request.diagnosis.value, made_of(*stored));
  events_.record(caller, "extension.accepted", std::move(detail));
  if (request.promote) {
    auto promoting = promote(caller, *stored->model);
    const auto promoted = co_await std::move(promoting);
    if (!promoted) co_return tl::unexpected(promoted.error());
  }
  co_return stored;
}

Awaitable<Result<ExtensionRecord>> CellApplication::undo_extension(Caller caller, DiagnosisId id) {
  auto undoing = writer_.call([id, at = clock_->now(), caller](Store& store) {
    return store.diagnoses().undo_extension(id, at, caller.name, caller.peer);
  });
  auto undone = co_await std::move(undoing);
  if (!undone) co_return undone;
  auto detail = fmt::format("{} undid {} of diagnosis {}: {} no longer in force", caller.name,
                            numbers_of(undone->findings), id.value, made_of(*undone));
  events_.record(caller, "extension.undone", std::move(detail));
  // The model before it serves again, unless another one was promoted since.
  if (undone->promoted && undone->model && serving_.model() == undone->model) {
    auto rolling = roll_back(caller);
    const auto back = co_await std::move(rolling);
    if (!back) co_return tl::unexpected(back.error());
  }
  co_return undone;
}

}  // namespace driftwise::application
