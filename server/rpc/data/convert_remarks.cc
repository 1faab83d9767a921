#include "server/rpc/data/convert_remarks.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/row_ranges.h"

namespace driftwise::rpc {
namespace {

constexpr std::int64_t kMostRows = 1'000'000;

template <class Request>
Result<ExclusionRecord> exclusion_of(const Request& request, bool excluded) {
  DRIFTWISE_RETURN_IF_ERROR(check_id(request.run_id(), "run_id"));
  DRIFTWISE_RETURN_IF_ERROR(check_size(request.reason(), kMostNoteBytes, "reason"));
  if (request.reason().find_first_not_of(" \t\r\n") == std::string::npos)
    return fail(ErrorCode::invalid_argument, reasons::kReasonRequired,
                "reason: found nothing, expected why: it stands in the record");
  DRIFTWISE_TRY(auto rows, rows_from(request.rows()));
  return ExclusionRecord{
      0, RunId{request.run_id()}, excluded, std::move(rows), clean_line(request.reason()), {}, {},
      {}};
}

}  // namespace

Result<std::vector<std::int64_t>> rows_from(
    const google::protobuf::RepeatedPtrField<v1::RowRange>& ranges) {
  if (ranges.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoRows,
                "rows: found none, expected at least one range");
  std::vector<std::int64_t> rows;
  for (const auto& range : ranges) {
    if (range.first_row() < 1 || range.last_row() < range.first_row())
      return fail(ErrorCode::invalid_argument, reasons::kBadRows,
                  "rows: found " + std::to_string(range.first_row()) + " to " +
                      std::to_string(range.last_row()) +
                      ", expected a first row from 1 and a last row not before it");
    if (range.last_row() - range.first_row() >= kMostRows - static_cast<std::int64_t>(rows.size()))
      return fail(ErrorCode::invalid_argument, reasons::kTooManyRows,
                  "rows: found more than " + std::to_string(kMostRows) + " of them");
    for (std::int64_t row = range.first_row(); row <= range.last_row(); ++row)
      rows.push_back(stored_row(row));
  }
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

Result<ExclusionRecord> exclusion_from(const v1::ExcludeRowsRequest& request) {
  return exclusion_of(request, true);
}
Result<ExclusionRecord> exclusion_from(const v1::RestoreRowsRequest& request) {
  return exclusion_of(request, false);
}

v1::ExclusionState exclusions_from(const application::ExclusionState& state) {
  v1::ExclusionState out;
  out.set_run_id(state.run.value);
  add_ranges(state.rows, [&] { return out.add_excluded_rows(); });
  add_ranges(state.suspect_rows, [&] { return out.add_suspect_rows(); });
  out.set_excluded_row_count(static_cast<std::int64_t>(state.rows.size()));
  out.set_exclusions_hash(state.hash);
  for (const auto& step : state.history) {
    auto& added = *out.add_history();
    added.set_id(step.id);
    added.set_excluded(step.excluded);
    add_ranges(step.rows, [&] { return added.add_rows(); });
    added.set_reason(utf8_from(step.reason));
    *added.mutable_exclude_time() = timestamp_from(step.at.utc);
    added.set_excluded_by(utf8_from(step.who));
    added.set_peer(step.from);
    added.set_suspect(step.suspect);
  }
  return out;
}

Result<NoteSubject> subject_from(const v1::NoteSubject& subject) {
  NoteSubject on;
  if (subject.has_run_id() == subject.has_model_id() ||
      (subject.has_row() && !subject.has_run_id()))
    return fail(ErrorCode::invalid_argument, reasons::kBadSubject,
                "on: expected a run, a run and one of its rows, or a model");
  if (subject.has_run_id()) {
    DRIFTWISE_RETURN_IF_ERROR(check_id(subject.run_id(), "on.run_id"));
    on.run = RunId{subject.run_id()};
  }
  if (subject.has_row()) {
    DRIFTWISE_RETURN_IF_ERROR(check_id(subject.row(), "on.row"));
    on.row = stored_row(subject.row());
  }
  if (subject.has_model_id()) {
    DRIFTWISE_RETURN_IF_ERROR(check_id(subject.model_id(), "on.model_id"));
    on.model = ModelId{subject.model_id()};
  }
  return on;
}

v1::Note note_from(const NoteRecord& note) {
  v1::Note out;
  out.set_id(note.id);
  if (note.on.run) out.mutable_on()->set_run_id(note.on.run->value);
  if (note.on.row) out.mutable_on()->set_row(shown_row(*note.on.row));
  if (note.on.model) out.mutable_on()->set_model_id(note.on.model->value);
  out.set_text(utf8_from(note.text));
  *out.mutable_create_time() = timestamp_from(note.at.utc);
  out.set_created_by(utf8_from(note.who));
  out.set_peer(note.from);
  return out;
}

}  // namespace driftwise::rpc
