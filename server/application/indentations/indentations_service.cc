#include "server/application/indentations/indentations_service.h"

#include <fmt/format.h>

#include "server/application/plumbing/run_on.h"
#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/formats/indentation/indentation_file.h"
#include "server/formats/indentation/indents_csv.h"
#include "server/formats/indentation/indents_json.h"
#include "server/formats/indentation/procedure_json.h"

namespace driftwise::application {
namespace {

constexpr const char* kFileName = "indentation.toml";
constexpr const char* kRecordName = "record_json";
constexpr const char* kTableName = "microscope.csv";

struct Computed {
  std::string json, verdict;
  indentation::Conformity conformity;
};

Result<Computed> computed_table(const formats::IndentationFile& file,
                                const indentation::ProcedureRecord& record,
                                const std::string& microscope_csv) {
  if (record.stage != indentation::Stage::microscope)
    return fail(
        ErrorCode::failed_precondition, reasons::kNotNow,
        fmt::format("{} of {} indents are made, the indentation is at stage {}: finish it "
                    "with driftwise indent start, then import the microscope's table",
                    record.indents.size(), file.rules.indents.size(), to_string(record.stage)));
  if (record.tool != file.rules.tool)
    return fail(ErrorCode::failed_precondition, reasons::kOtherTool,
                fmt::format("the indents were made with tool {}, the file names {}: its lever and "
                            "force would be another tool's",
                            shown(record.tool), shown(file.rules.tool)));
  DRIFTWISE_TRY(const auto rows, formats::read_microscope_csv(microscope_csv, kTableName));
  DRIFTWISE_TRY(const auto indents, indentation::indents_seen(record, rows));
  DRIFTWISE_TRY(const auto table, indentation::indent_table(indents, file.tool));
  DRIFTWISE_TRY(const auto report, indentation::tip_report(table, file.wanted_um));
  return Computed{formats::indents_json(table, report, file.tool), report.verdict,
                  report.conformity};
}

Result<IndentationView> view_of(IndentationRecord& record) {
  DRIFTWISE_TRY(const auto file, formats::read_indentation_file(record.file_text, kFileName));
  DRIFTWISE_TRY(const auto procedure,
                formats::read_procedure_json(record.record_json, kRecordName));
  IndentationView view{.record = record};
  view.name = file.name;
  view.tool = procedure.tool.empty() ? file.rules.tool : procedure.tool;
  view.stage = to_string(procedure.stage);
  view.revision = procedure.revision;
  view.contacts = procedure.contacts;
  view.made = static_cast<int>(procedure.indents.size());
  view.planned = static_cast<int>(file.rules.indents.size());
  view.in_contact = procedure.in_contact;
  if (!record.microscope_csv.empty()) {
    const auto table = computed_table(file, procedure, record.microscope_csv);
    if (!table) {
      view.table_trouble = table.error().message;
    } else {
      view.table_json = table->json;
      view.verdict = table->verdict;
      view.conformity = table->conformity;
    }
  }
  return view;
}

// Refusals of a report. A damaged text of the caller is the caller's.
Result<IndentationView> judged_indents(IndentationRecord& now, const IndentationRecord& before) {
  auto view = view_of(now);
  if (!view) {
    view.error().code = ErrorCode::invalid_argument;
    return view;
  }
  if (before.id == IndentationId{}) return view;
  DRIFTWISE_TRY(const auto stored, formats::read_procedure_json(before.record_json, kRecordName));
  // Records from before there were revisions, both 0: by the contacts.
  const bool is_older =
      view->revision < stored.revision ||
      (view->revision == 0 && stored.revision == 0 && view->contacts < stored.contacts);
  if (is_older)
    return fail(ErrorCode::failed_precondition, reasons::kNotNow,
                fmt::format("this record of indentation {} has {} contacts, the daemon's has {} "
                            "(revisions {} and {}): it is an older copy, and its next places are "
                            "used. Take the newer one (driftwise indent show {} -o "
                            "FILE.state.json), or begin anew on a fresh surface with --fresh",
                            before.id.value, view->contacts, stored.contacts, view->revision,
                            stored.revision, before.id.value));
  if (!stored.tool.empty() && view->tool != stored.tool)
    return fail(ErrorCode::failed_precondition, reasons::kOtherTool,
                fmt::format("indentation {} was begun with tool {}, this record names {}: contacts "
                            "of two tools have no common zero. Begin a new one with --fresh",
                            before.id.value, shown(stored.tool), shown(view->tool)));
  return view;
}

Result<Computed> table_to_import(IndentationRecord& record) {
  DRIFTWISE_TRY(const auto file, formats::read_indentation_file(record.file_text, kFileName));
  DRIFTWISE_TRY(const auto procedure,
                formats::read_procedure_json(record.record_json, kRecordName));
  return computed_table(file, procedure, record.microscope_csv);
}

// A record that this program cannot read any more is shown with the reason.
IndentationView readable(IndentationRecord& record) {
  auto view = view_of(record);
  if (view) return std::move(*view);
  IndentationView damaged{.record = record};
  damaged.name = view.error().message;
  return damaged;
}

std::vector<IndentationView> all_readable(std::vector<IndentationRecord>& records) {
  std::vector<IndentationView> views;
  for (auto& record : records) views.push_back(readable(record));
  return views;
}

std::string subject_of(IndentationId id) { return fmt::format("indentation {}", id.value); }

}  // namespace

Awaitable<Result<IndentationView>> IndentationsService::begin(Caller caller, std::string key,
                                                              std::string file_text,
                                                              std::string record_json) {
  if (key.empty())
    co_return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                   "key: found nothing, expected a name of this indentation that stays: `driftwise "
                   "indent start` makes one");
  IndentationRecord fresh;
  fresh.key = std::move(key);
  fresh.file_text = std::move(file_text);
  fresh.record_json = std::move(record_json);
  fresh.created = fresh.reported = clock_.now().utc;
  fresh.created_by = caller.name;
  fresh.created_from = caller.peer;
  const IndentationRecord none;
  DRIFTWISE_CO_TRY(auto view, co_await run_on(texts_, judged_indents, fresh, none));
  auto adding = writer_.indentations().add_indentation(fresh);
  DRIFTWISE_CO_TRY(auto stored, co_await std::move(adding));
  // Another one than the fresh record: the key is known, and this continues its indentation.
  if (stored.created != fresh.created || stored.record_json != fresh.record_json ||
      !stored.ended.empty())
    co_return co_await replace(std::move(caller), std::move(stored), std::move(fresh.file_text),
                               std::move(fresh.record_json), {});
  view.record = std::move(stored);
  events_.record(caller, "indentation.begun",
                 fmt::format("{} began indentation {}, {}, with tool {}", caller.name,
                             view.record.id.value, shown(view.name), shown(view.tool)),
                 {}, {subject_of(view.record.id), "", view.name});
  co_return view;
}

Awaitable<Result<IndentationView>> IndentationsService::report(Caller caller, IndentationId id,
                                                               std::string record_json,
                                                               std::string ended) {
  auto reading = writer_.indentations().indentation(id);
  DRIFTWISE_CO_TRY(auto stored, co_await std::move(reading));
  auto file_text = stored.file_text;
  co_return co_await replace(std::move(caller), std::move(stored), std::move(file_text),
                             std::move(record_json), std::move(ended));
}

Awaitable<Result<IndentationView>> IndentationsService::replace(Caller caller,
                                                                IndentationRecord stored,
                                                                std::string file_text,
                                                                std::string record_json,
                                                                std::string ended) {
  IndentationRecord now = stored;
  now.file_text = std::move(file_text);
  now.record_json = std::move(record_json);
  now.ended = std::move(ended);
  now.reported = clock_.now().utc;
  DRIFTWISE_CO_TRY(auto view, co_await run_on(texts_, judged_indents, now, stored));
  auto changing = writer_.indentations().change_indentation(now);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(changing));
  if (!now.ended.empty())
    events_.record(caller, "indentation.ended",
                   fmt::format("indentation {} ended at stage {} with {} of {} indents: {}",
                               now.id.value, view.stage, view.made, view.planned, now.ended),
                   {}, {subject_of(now.id), "", now.ended});
  co_return view;
}

Awaitable<Result<IndentationView>> IndentationsService::import_table(Caller caller,
                                                                     IndentationId id,
                                                                     std::string microscope_csv) {
  auto reading = writer_.indentations().indentation(id);
  DRIFTWISE_CO_TRY(auto record, co_await std::move(reading));
  record.microscope_csv = std::move(microscope_csv);
  DRIFTWISE_CO_TRY(const auto table, co_await run_on(texts_, table_to_import, record));
  auto changing = writer_.indentations().change_indentation(record);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(changing));
  events_.record(caller, "indentation.judged",
                 fmt::format("{} imported the microscope's table of indentation {}: {}",
                             caller.name, id.value, table.verdict),
                 {}, {subject_of(id), "", table.verdict});
  co_return co_await run_on(texts_, view_of, std::move(record));
}

Awaitable<Result<std::vector<IndentationView>>> IndentationsService::list(int limit) {
  auto reading = reader_.indentations().indentations(limit);
  DRIFTWISE_CO_TRY(auto records, co_await std::move(reading));
  co_return co_await run_on(texts_, all_readable, std::move(records));
}

Awaitable<Result<IndentationView>> IndentationsService::get(IndentationId id) {
  auto reading = reader_.indentations().indentation(id);
  DRIFTWISE_CO_TRY(auto record, co_await std::move(reading));
  co_return co_await run_on(texts_, readable, std::move(record));
}

}  // namespace driftwise::application
