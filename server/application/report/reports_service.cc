#include "server/application/report/reports_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "server/application/plumbing/run_on.h"
#include "server/application/ports/run_plan.h"
#include "server/calibration/report/accuracy.h"
#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

using formats::RunReport;

constexpr int kEntriesOfStory = 1000, kAlarmsOfStory = 2000, kEventsOfPage = 2000,
              kPointsOfPage = 2000;
constexpr std::size_t kMostEvents = 20'000;

// The entry and, before it, those that it had to wait for.
std::vector<QueueEntry> chain_of(const std::vector<QueueEntry>& all, QueueEntryId last) {
  std::vector<QueueEntry> chain;
  for (std::optional<QueueEntryId> id = last; id;) {
    const auto found = std::ranges::find(all, *id, &QueueEntry::id);
    if (found == all.end() || chain.size() == all.size()) break;
    chain.insert(chain.begin(), *found);
    id = found->after;
  }
  return chain;
}

Result<std::vector<PointRecord>> points_of(Store& store, RunId run) {
  DRIFTWISE_TRY(const auto repeated, store.closures().repeated_points(run));
  const std::set<std::int64_t> left_out = [&] {
    std::set<std::int64_t> ids;
    for (const PointId id : repeated) ids.insert(id.value);
    return ids;
  }();
  std::vector<PointRecord> points;
  for (std::int64_t after = 0;;) {
    DRIFTWISE_TRY(auto page, store.points().points(run, after, kPointsOfPage));
    for (auto& point : page) {
      after = point.id.value;
      if (!left_out.contains(after) && !point.passage) points.push_back(std::move(point));
    }
    if (page.size() < kPointsOfPage) return points;
  }
}

// Of the runs of the story, and of no run while it went on. The newest, where there are too many.
Result<std::vector<EventRecord>> events_of(Store& store, const RunReport& report, CellTime begin,
                                           CellTime end) {
  std::vector<EventRecord> events;
  for (EventId after{};;) {
    DRIFTWISE_TRY(auto page, store.events().events(after, kEventsOfPage));
    for (auto& event : page) {
      after = event.id;
      const auto at = event.at.utc;
      const bool of_story = event.run ? *event.run == report.run.id ||
                                            std::ranges::find(report.runs, *event.run,
                                                              &RunRecord::id) != report.runs.end()
                                      : at >= begin && at <= end;
      if (of_story) events.push_back(std::move(event));
    }
    if (page.size() < kEventsOfPage) break;
  }
  if (events.size() > kMostEvents)
    events.erase(events.begin(), events.end() - static_cast<std::ptrdiff_t>(kMostEvents));
  return events;
}

// The part of a story that the store alone can say. now: its end, for a run that is under way.
Result<void> read_story(Store& store, std::shared_ptr<RunReport>& to, CellTime now) {
  auto& report = *to;
  const RunId id = report.run.id;
  DRIFTWISE_TRY(report.points, points_of(store, id));
  DRIFTWISE_TRY(report.attempts, store.points().attempts(id));
  DRIFTWISE_TRY(report.closures, store.closures().closures(id));
  DRIFTWISE_TRY(report.head, store.audit().head());
  CellTime begin = report.run.created, end = now;
  if (is_over(report.run.state)) end = report.run.ended;
  if (report.run.queue_entry) {
    DRIFTWISE_TRY(const auto queue, store.queue().queue(kEntriesOfStory));
    report.entries = chain_of(queue.entries, *report.run.queue_entry);
    for (const auto& entry : report.entries) {
      RunRecord run;
      if (entry.run && *entry.run != id) {
        DRIFTWISE_TRY(run, store.runs().run(*entry.run));
      } else if (entry.run) {
        run = report.run;
      }
      if (run.created.utc_ns != 0) begin = std::min(begin, run.created);
      if (is_over(report.run.state))
        for (const auto& result : entry.results) end = std::max(end, result.at);
      if (entry.state == QueueState::following) end = now;
      run.trajectory_text.clear();
      report.runs.push_back(std::move(run));
    }
  }
  DRIFTWISE_TRY(auto alarms, store.alarms().alarms(true, kAlarmsOfStory));
  std::erase_if(alarms, [&](const AlarmRecord& alarm) {
    return alarm.since > end || (alarm.cleared.utc_ns != 0 && alarm.cleared < begin);
  });
  std::ranges::sort(alarms, {}, &AlarmRecord::since);
  report.alarms = std::move(alarms);
  DRIFTWISE_TRY(report.events, events_of(store, report, begin, end));
  return {};
}

// Enough points but returns to zero that have a wanted pose: then the run can be verified.
bool has_wanted_poses(const std::vector<PointRecord>& points) {
  int found = 0;
  for (const auto& point : points)
    found += !point.zero && std::ranges::any_of(point.values, [](const auto& value) {
      return value.channel.find("_target_") != std::string::npos && !is_missing(value.value);
    });
  return found >= 2;
}

std::string in_words(const Compensation& of) {
  if (!of.compensated) return "uncompensated";
  return std::string("compensated ") + (of.plan ? "by " : "with ") + compensation_text(of);
}

Result<std::string> text_of_page(const std::shared_ptr<RunReport>& report,
                                 const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  if (path.empty() || !file || page.empty())
    return fail(ErrorCode::failed_precondition, reasons::kNoWebPage,
                fmt::format("the page of reports was not found{}: build it (cmake --build BUILD "
                            "--target web) or install it beside the program",
                            path.empty() ? "" : " at " + path));
  return formats::report_page(page, formats::run_report_json(*report));
}

}  // namespace

std::string report_path(const std::string& database, QueueEntryId entry, RunId run) {
  const auto folder = std::filesystem::path(database).parent_path() / "reports";
  return (folder / fmt::format("queue-{}-run-{}.html", entry.value, run.value)).string();
}

Result<void> write_report(const std::string& path, const std::string& text) {
  namespace fs = std::filesystem;
  std::error_code failed;
  fs::create_directories(fs::path(path).parent_path(), failed);
  const auto part = path + ".part";
  if (!failed) {
    std::ofstream file(part, std::ios::binary | std::ios::trunc);
    file << text;
    file.close();
    if (file)
      fs::rename(part, path, failed);
    else
      failed = std::make_error_code(std::errc::io_error);
  }
  if (!failed) return {};
  std::error_code ignored;
  fs::remove(part, ignored);
  return fail(ErrorCode::internal, reasons::kCannotWrite,
              fmt::format("the report {} cannot be written: {}: look at the folder's rights and "
                          "its room",
                          path, failed.message()));
}

ReportsService::ReportsService(Parts parts, std::string version, std::string page_template)
    : parts_(std::move(parts)),
      version_(std::move(version)),
      page_template_(std::move(page_template)) {}

Awaitable<Result<std::string>> ReportsService::page(RunId id) {
  co_await parts_.bench.events.written();
  const auto& clock = parts_.bench.clock;
  const auto report = std::make_shared<RunReport>();
  auto getting = parts_.runs.get(id);
  DRIFTWISE_CO_TRY(report->run, co_await std::move(getting));
  report->run.trajectory_text.clear();
  const auto now = clock.now().utc;
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await parts_.reader.call(read_story, report, now));
  auto looking = parts_.provenance.grounds_of_runs({id});
  DRIFTWISE_CO_TRY(auto grounds, co_await std::move(looking));
  report->configurations = std::move(grounds.front().configurations);
  report->corrections = std::move(grounds.front().corrections);
  if (has_wanted_poses(report->points)) {
    // A run that cannot be judged (all rows kept out, say) has a report all the same.
    auto verifying = parts_.checks.verify_runs({id}, {});
    if (auto found = co_await std::move(verifying)) report->verification = std::move(*found);
  }
  if (!report->entries.empty()) {
    const auto results = report->entries.back().results;
    for (const auto& result : results) {
      if (result.model) {
        auto reading = model_of(*result.model, id);
        report->models.push_back(co_await std::move(reading));
      }
      if (result.diagnosis) {
        auto reading = diagnosis_of(*result.diagnosis);
        report->diagnoses.push_back(co_await std::move(reading));
      }
    }
  }
  const auto& cell = parts_.bench.description;
  report->cell = cell.name;
  report->version = version_;
  report->axes = cell.axes();
  if (!report->configurations.empty()) report->certificates = cell.certificates;
  report->compensation = in_words(compensation_of(report->run));
  report->made_utc_ns = clock.utc(now).ns;
  report->made = to_iso8601(clock.utc(now));
  report->utc = [&clock](CellTime at) { return clock.utc(at); };
  co_return co_await run_on(parts_.background, text_of_page, report, page_template_);
}

Awaitable<formats::ReportedModel> ReportsService::model_of(ModelId id, RunId run) {
  formats::ReportedModel out;
  out.id = id;
  auto getting = parts_.models.get(id);
  const auto record = co_await std::move(getting);
  if (!record) {
    out.trouble = record.error().message;
    co_return out;
  }
  out.name = record->name;
  const auto model = formats::read_model_json(record->json);
  if (!model) {
    out.trouble = model.error().message;
    co_return out;
  }
  out.formula = model->formula;
  out.accuracy = calibration::heading_of(*model);
  auto computing = parts_.models.residuals(id, {run}, {});
  const auto residuals = co_await std::move(computing);
  if (!residuals) {
    out.trouble = residuals.error().message;
    co_return out;
  }
  const auto& data = residuals->data;
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < data.rows; ++row)
    if (!is_passage(data, row)) rows.push_back(row);
  for (const auto row : rows) {
    out.time_s.push_back(data.time_s.empty() ? static_cast<double>(row) : data.time_s[row]);
    out.check.push_back(data.set_of(row) == PointSet::validation ? 1 : 0);
  }
  for (const auto& output : residuals->outputs) {
    std::vector<double> values;
    for (const auto row : rows) values.push_back(output.values[row]);
    out.residuals.push_back({output.channel.symbol,
                             std::string(summary_unit(output.channel.unit).unit),
                             std::move(values)});
  }
  co_return out;
}

Awaitable<formats::ReportedDiagnosis> ReportsService::diagnosis_of(DiagnosisId id) {
  formats::ReportedDiagnosis out;
  out.id = id;
  auto getting = parts_.diagnoses.get(id);
  const auto view = co_await std::move(getting);
  if (!view) {
    out.state = view.error().message;
    co_return out;
  }
  out.state = std::string(to_string(view->record.state));
  out.baseline = view->record.baseline;
  out.extended = view->record.extended;
  if (!view->found) co_return out;
  out.verdict = std::string(diagnosis::to_string(view->found->verdict));
  for (const auto& finding : view->found->findings) out.findings.push_back(finding.sentence);
  for (const auto& rest : view->found->left_over) out.left_over.push_back(rest.goes_with);
  co_return out;
}

}  // namespace driftwise::application
