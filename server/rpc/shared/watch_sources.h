#pragma once
// What the streaming calls send, each as a StreamSource (stream.h): how a slow client is treated is
// decided here.
//
// progress, jobs, targets: the latest state only. events: all of them, by cursor from the record.
// readings: the newest 256, and a count of those missed. export, archive, report: all of it, in
// pieces, within the memory that there is for whole texts (whole_texts.h).

#include <functional>
#include <memory>
#include <optional>

#include "driftwise/v1/cell_service.pb.h"
#include "driftwise/v1/data_service.pb.h"
#include "driftwise/v1/diagnosis_service.pb.h"
#include "driftwise/v1/record_service.pb.h"
#include "driftwise/v1/run_service.pb.h"
#include "driftwise/v1/target_service.pb.h"
#include "server/application/cell/services.h"
#include "server/application/ports/caller.h"
#include "server/compensation/target.h"
#include "server/rpc/shared/stream.h"
#include "server/rpc/shared/whole_texts.h"

namespace driftwise::rpc {

// run: none means the one under way. Ends after the state in which the run is over.
// Errors: not_found; failed_precondition NO_RUN.
std::unique_ptr<StreamSource<v1::WatchRunResponse>> watch_run(const application::Host& host,
                                                              const application::Overview& overview,
                                                              application::Runs& runs,
                                                              std::optional<RunId> run);

// End after the state in which the job is over. Errors: not_found.
std::unique_ptr<StreamSource<v1::WatchDiagnosisResponse>> watch_diagnosis(
    const application::Host& host, application::Diagnoses& diagnoses, DiagnosisId id);
std::unique_ptr<StreamSource<v1::WatchImprovementResponse>> watch_improvement(
    const application::Host& host, application::Improvements& improvements,
    application::StoreReader& records, ImprovementId id);

// after: none means from now on. Never ends by itself.
std::unique_ptr<StreamSource<v1::WatchEventsResponse>> watch_events(
    const application::Host& host, application::Feeds& feeds, application::StoreReader& records,
    std::optional<EventId> after);

// device: empty for all. Never ends by itself.
std::unique_ptr<StreamSource<v1::WatchReadingsResponse>> watch_readings(application::Feeds& feeds,
                                                                        std::string device);

// The first at once, then one after each rebuild of the snapshot, at least min_interval of wall
// time apart. Ends with the error when a target is refused (no model serves, or the cell refuses
// stale ones): ask again later. take_place: one of the places of those who search an arm's joints,
// given back with the last owner; null: all are taken, and the target comes a second later.
std::unique_ptr<StreamSource<v1::WatchTargetsResponse>> watch_targets(
    const application::Host& host, application::Targets& targets,
    compensation::TargetRequest request, Nanoseconds min_interval,
    std::function<std::shared_ptr<void>()> take_place);

std::unique_ptr<StreamSource<v1::ExportDatasetResponse>> export_dataset(
    std::shared_ptr<WholeTexts> texts, application::Datasets& datasets, std::vector<RunId> runs,
    bool without_excluded);

// The whole archive, in pieces.
std::unique_ptr<StreamSource<v1::GetSupportBundleResponse>> support_bundle(
    std::shared_ptr<WholeTexts> texts, application::SupportBundles& bundles,
    application::Caller caller);

// The whole page, in pieces. Ends with BAD_ID for a run that no number of a run can be.
std::unique_ptr<StreamSource<v1::GetReportResponse>> run_report(std::shared_ptr<WholeTexts> texts,
                                                                application::Reports& reports,
                                                                std::int64_t run);

}  // namespace driftwise::rpc
