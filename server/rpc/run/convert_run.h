#pragma once
// Runs, their points, attempts and datums: domain -> proto; a run's rules: proto -> domain.

#include "driftwise/v1/run.pb.h"
#include "server/application/ports/run_hold.h"
#include "server/application/runs/run_progress.h"
#include "server/core/description/cell_description.h"
#include "server/core/records/closure_records.h"

namespace driftwise::rpc {

v1::Run run_from(const RunRecord& run);
void add_metadata(const RunMetadata& metadata,
                  google::protobuf::RepeatedPtrField<v1::MetadataItem>& out);
// Errors: invalid_argument BAD_METADATA.
Result<RunMetadata> metadata_from(
    const google::protobuf::RepeatedPtrField<v1::MetadataItem>& items);
// Errors: invalid_argument (a reason that is too long).
Result<application::HoldAnswer> answer_from(const v1::HoldAnswer& answer);
// Cell time, with the share of the outcomes and what it rests on.
v1::DurationBand band_from(const application::Outlook& outlook);
v1::RunProgress progress_from(const application::RunProgress& progress);
v1::Point point_from(const PointRecord& point);
v1::Attempt attempt_from(const AttemptRecord& attempt);
v1::Datum datum_from(const DatumRecord& datum);
v1::Closure closure_from(const ClosureRecord& closure);

// The cell's rules with what the request sets. Errors: invalid_argument; BAD_RULE (not finite,
// negative or absurd, naming the field and the range), BAD_DURATION.
Result<RunRules> rules_from(const v1::RunRules& request, RunRules rules);

}  // namespace driftwise::rpc
