#pragma once
// Exclusions and notes: requests -> domain with their checks, domain -> proto.

#include "driftwise/v1/data_service.pb.h"
#include "server/application/annotations/annotations.h"

namespace driftwise::rpc {

// Rows, ascending, each once. Errors: invalid_argument; NO_ROWS, BAD_ROWS (negative, or first after
// last), TOO_MANY_ROWS (more than a million).
Result<std::vector<std::int64_t>> rows_from(
    const google::protobuf::RepeatedPtrField<v1::RowRange>& ranges);

// What ExcludeRows and RestoreRows ask for. Errors: those of rows_from; BAD_ID, TOO_LONG,
// REASON_REQUIRED.
Result<ExclusionRecord> exclusion_from(const v1::ExcludeRowsRequest& request);
Result<ExclusionRecord> exclusion_from(const v1::RestoreRowsRequest& request);

v1::ExclusionState exclusions_from(const application::ExclusionState& state);

// Errors: invalid_argument; BAD_SUBJECT, BAD_ID, BAD_CURSOR (row).
Result<NoteSubject> subject_from(const v1::NoteSubject& subject);
v1::Note note_from(const NoteRecord& note);

}  // namespace driftwise::rpc
