#include "driftwise/v1/data_service.grpc.pb.h"
#include "server/application/annotations/annotations.h"
#include "server/application/datasets/datasets.h"
#include "server/application/plumbing/store_reader.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/data/convert_remarks.h"
#include "server/rpc/data/join_request.h"
#include "server/rpc/run/convert_run.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

class DataService final : public v1::DataService::CallbackService {
 public:
  explicit DataService(const application::Services& cell)
      : host_(cell.host),
        records_(cell.records),
        datasets_(cell.datasets),
        annotations_(cell.annotations),
        texts_(WholeTexts::make(cell.host.executor())) {}

  grpc::ServerWriteReactor<v1::ExportDatasetResponse>* ExportDataset(
      grpc::CallbackServerContext*, const v1::ExportDatasetRequest* request) override {
    auto runs = run_ids_from(request->run_ids());
    if (!runs) return refuse_stream<v1::ExportDatasetResponse>(runs.error());
    if (runs->empty())
      return refuse_stream<v1::ExportDatasetResponse>(
          {ErrorCode::invalid_argument, reasons::kNoRuns,
           "run_ids: found none, expected at least one"});
    return Stream<v1::ExportDatasetResponse>::open(
        host_.executor(),
        export_dataset(texts_, datasets_, std::move(*runs), request->without_excluded()));
  }

  grpc::ServerUnaryReactor* ImportDataset(grpc::CallbackServerContext* context,
                                          const v1::ImportDatasetRequest* request,
                                          v1::ImportDatasetResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto name, line_from(request->name(), kMostNameBytes, "name"));
      if (auto good = check_size(request->csv(), kMostDatasetBytes, "csv"); !good) co_return good;
      if (auto good = check_size(request->request_id(), kMostRequestIdBytes, "request_id"); !good)
        co_return good;
      auto importing =
          datasets_.import_csv(caller_of(*context), name, request->csv(), request->request_id());
      DRIFTWISE_CO_TRY(const auto run, co_await std::move(importing));
      *response->mutable_run() = run_from(run);
      co_return Result<void>{};
    });
  }

  Reactor* JoinRuns(Context* context, const v1::JoinRunsRequest* request,
                    v1::JoinRunsResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto wanted, join_from(*request));
      auto joining = datasets_.join(caller_of(*context), std::move(wanted));
      DRIFTWISE_CO_TRY(const auto joined, co_await std::move(joining));
      if (joined.run) *response->mutable_run() = run_from(*joined.run);
      response->set_report_json(joined.report_json);
      co_return Result<void>{};
    });
  }

  Reactor* ExcludeRows(Context* context, const v1::ExcludeRowsRequest* request,
                       v1::ExcludeRowsResponse* response) override {
    return change_rows(context, *request, *response);
  }
  Reactor* RestoreRows(Context* context, const v1::RestoreRowsRequest* request,
                       v1::RestoreRowsResponse* response) override {
    return change_rows(context, *request, *response);
  }

  Reactor* ListExclusions(Context* context, const v1::ListExclusionsRequest* request,
                          v1::ListExclusionsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->run_id(), "run_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(const auto state,
                       co_await annotations_.exclusions(RunId{request->run_id()}));
      *response->mutable_state() = exclusions_from(state);
      co_return Result<void>{};
    });
  }

  Reactor* CreateNote(Context* context, const v1::CreateNoteRequest* request,
                      v1::CreateNoteResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto on, subject_from(request->on()));
      if (auto good = check_size(request->text(), kMostNoteBytes, "text"); !good) co_return good;
      if (request->text().empty())
        co_return fail(ErrorCode::invalid_argument, reasons::kNoText,
                       "text: found nothing to note");
      auto noting = annotations_.add_note(caller_of(*context), on, clean_text(request->text()));
      DRIFTWISE_CO_TRY(const auto note, co_await std::move(noting));
      *response->mutable_note() = note_from(note);
      co_return Result<void>{};
    });
  }

  Reactor* ListNotes(Context* context, const v1::ListNotesRequest* request,
                     v1::ListNotesResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto on, subject_from(request->on()));
      DRIFTWISE_CO_TRY(const auto notes, co_await records_.remarks().notes(on));
      for (const auto& note : notes) *response->add_notes() = note_from(note);
      co_return Result<void>{};
    });
  }

 private:
  template <class Request, class Response>
  Reactor* change_rows(Context* context, const Request& request, Response& response) {
    return answer(
        host_, context, [this, context, &request, &response]() -> Awaitable<Result<void>> {
          DRIFTWISE_CO_TRY(auto wanted, exclusion_from(request));
          auto changing = annotations_.exclude_rows(caller_of(*context), std::move(wanted));
          DRIFTWISE_CO_TRY(const auto state, co_await std::move(changing));
          *response.mutable_state() = exclusions_from(state);
          co_return Result<void>{};
        });
  }

  application::Host& host_;
  application::StoreReader& records_;
  application::Datasets& datasets_;
  application::Annotations& annotations_;
  std::shared_ptr<WholeTexts> texts_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_data_service(const application::Services& cell) {
  return std::make_unique<DataService>(cell);
}

}  // namespace driftwise::rpc
