#pragma once
// Diagnoses and improvements: requests -> domain with their checks, domain -> proto.

#include "driftwise/v1/diagnosis_service.pb.h"
#include "server/application/diagnoses/diagnoses.h"
#include "server/application/diagnoses/extensions.h"
#include "server/application/improvement/improvements.h"
#include "server/formats/diagnosis/stored_diagnosis.h"

namespace driftwise::rpc {

// Errors: invalid_argument; RUNS_OR_CSV (neither or both), BAD_ID, DUPLICATE_RUN, TOO_LONG,
// BAD_ALPHA (not inside 0 to 0.5), BAD_OPTION (seed).
Result<application::DiagnosisRequest> diagnosis_request_from(
    const v1::CreateDiagnosisRequest& request);
// Errors: BAD_ID, BAD_FINDING (below 1).
Result<application::AcceptRequest> accept_request_from(const v1::AcceptExtensionRequest& request);
// Errors: EMPTY_TRAJECTORY, TOO_LONG, BAD_TURNS, BAD_BUDGET.
Result<application::ImproveRequest> improve_request_from(
    const v1::CreateImprovementRequest& request);

enum class DiagnosisDetail { summary, whole };  // summary: without json and curves
v1::Diagnosis diagnosis_from(const application::DiagnosisView& view, DiagnosisDetail detail);
v1::DiagnosisProgress diagnosis_progress_from(const application::DiagnosisProgress& progress);
v1::DiscrepancyRows rows_from(const formats::DiscrepancyRows& rows);
v1::Extension extension_from(const ExtensionRecord& extension);
v1::Improvement improvement_from(const ImprovementRecord& record);
v1::ImprovementProgress improvement_progress_from(const application::ImprovementProgress& progress);

}  // namespace driftwise::rpc
