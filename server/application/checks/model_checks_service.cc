// The check standard: does the robot still do what a model says? Asked by people, and by the cell
// itself after every run.

#include "server/application/checks/model_checks_service.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/models/model_integrity.h"
#include "server/application/models/run_to_check.h"
#include "server/application/plumbing/run_on.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/diagnosis/check/check_memory.h"
#include "server/formats/diagnosis/robot_names.h"
#include "server/plans/robot_parts.h"

namespace driftwise::application {
namespace {

constexpr int kMostRuns = 50;  // older ones weigh less than 1e-4 in an EWMA of lambda 0.2

struct Material {
  ModelRecord model;
  std::vector<RunRecord> runs;
  std::vector<diagnosis::RunToCheck> data;
};

Result<std::vector<RunRecord>> runs_since(Store& store, const ModelRecord& model,
                                          const std::vector<RunId>& fitted_from) {
  constexpr int kPage = 100;
  std::vector<RunRecord> found;
  for (std::int64_t before = 0; static_cast<int>(found.size()) < kMostRuns;) {
    DRIFTWISE_TRY(auto page, store.runs().runs(kPage, before));
    for (auto& run : page) {
      before = run.id.value;
      const bool own = std::ranges::find(fitted_from, run.id) != fitted_from.end();
      if (run.created > model.created && !own && run.accepted > 0 && run.reason != "imported" &&
          static_cast<int>(found.size()) < kMostRuns)
        found.push_back(std::move(run));
    }
    if (static_cast<int>(page.size()) < kPage || page.back().created < model.created) break;
  }
  std::ranges::reverse(found);
  return found;
}

Result<Material> gather(Store& store, ModelId id, const std::vector<RunId>& wanted,
                        std::optional<CorrectionId> leaving_out) {
  DRIFTWISE_TRY(auto record, store.models().model(id));
  DRIFTWISE_RETURN_IF_ERROR(check_integrity(record));
  Material material{std::move(record), {}, {}};
  DRIFTWISE_TRY(const auto model, read_formula_model(material.model, "runs are checked"));
  const auto memory = diagnosis::memory_of(model);
  if (wanted.empty()) {
    DRIFTWISE_TRY(auto since, runs_since(store, material.model, model.lineage.runs));
    material.runs = std::move(since);
  }
  for (const RunId run : wanted) {
    DRIFTWISE_TRY(auto one, store.runs().run(run));
    material.runs.push_back(std::move(one));
  }
  for (const auto& run : material.runs) {
    DRIFTWISE_TRY(auto to_check, run_to_check(store, run, memory, leaving_out));
    material.data.push_back(std::move(to_check));
  }
  return material;
}

// A model of one robot of several is checked on that robot's part of the runs. One that reads
// another robot's coordinates has no such part: its runs count without their zero.
diagnosis::CheckReport report_of(const calibration::Model& model,
                                 std::vector<diagnosis::RunToCheck> runs) {
  const auto robot = formats::robot_of_formula(model.formula);
  const auto part = plans::part_of_robot(model, robot);
  if (robot.empty() || !part || runs.empty()) return diagnosis::check_model(model, runs);
  const formats::RobotNames names(runs.back().data, robot);
  for (auto& run : runs) {
    run.data = names.bare(std::move(run.data));
    for (auto& zero : run.zeros) zero = plans::part_of_robot(zero, robot);
  }
  auto report = diagnosis::check_model(*part, runs);
  for (auto& reason : report.reasons) reason = names.with_id(reason);
  for (auto& output : report.outputs) {
    output.channel.symbol = names.with_id(output.channel.symbol);
    for (auto& point : output.points) {
      point.why_not = names.with_id(point.why_not);
      for (auto& sentence : point.out_of_control) sentence = names.with_id(sentence);
    }
  }
  return report;
}

Result<ModelCheck> judge(Material material) {
  DRIFTWISE_TRY(const auto model, read_formula_model(material.model, "runs are checked"));
  auto report = report_of(model, std::move(material.data));
  return ModelCheck{material.model.id, std::move(material.runs), std::move(report)};
}

}  // namespace

Awaitable<Result<ModelCheck>> ModelChecksService::check_model(
    std::optional<ModelId> id, std::vector<RunId> runs, std::optional<CorrectionId> leaving_out) {
  if (!id) id = serving_.model();
  if (!id)
    co_return fail(ErrorCode::failed_precondition, reasons::kNoModel,
                   "no model serves: name one, or promote one");
  DRIFTWISE_CO_TRY(auto material, co_await reader_.call(gather, *id, runs, leaving_out));
  co_return co_await run_on(
      worker_, [](Material& whole) { return judge(std::move(whole)); }, std::move(material));
}

void ModelChecksService::set_trouble(std::string trouble) {
  trouble_ = std::move(trouble);
  serving_.doubt(trouble_.empty() ? std::nullopt : serving_.model());
}

void ModelChecksService::served_another(bool any) {
  set_trouble("");
  if (!any) return;
  tasks_.spawn(check_served(std::nullopt));
}

void ModelChecksService::check_after(const RunProgress& progress) {
  if (!is_over(progress.run.state) || progress.run.accepted == 0 || !serving_.model() ||
      checked_ == progress.run.id)
    return;
  checked_ = progress.run.id;
  tasks_.spawn(check_served(progress.run.id));
}

// after: the run that ended just now; none: nothing new was measured, so nothing is recorded.
Awaitable<void> ModelChecksService::check_served(std::optional<RunId> after) {
  const auto model = serving_.model();
  auto checking = check_model(model, {}, {});
  const auto check = co_await std::move(checking);
  if (!check) {
    if (after) events_.record_own("check.failed", check.error().message, after);
  } else if (serving_.model() == model) {
    const auto& report = check->report;
    set_trouble(
        report.verdict == diagnosis::CheckVerdict::recalibrate
            ? fmt::format("recalibrate now: the robot no longer does what model {} says: {}",
                          model->value, fmt::join(report.reasons, "; "))
            : "");
    const bool says_it = after && !check->runs.empty() && check->runs.back().id == *after;
    if (says_it && report.verdict == diagnosis::CheckVerdict::recalibrate)
      events_.record_own("check.recalibrate", trouble_, after);
    else if (says_it && report.verdict == diagnosis::CheckVerdict::in_control)
      events_.record_own("check.in_control",
                         fmt::format("run {} is as model {} says", after->value, model->value),
                         after);
  }
}

}  // namespace driftwise::application
