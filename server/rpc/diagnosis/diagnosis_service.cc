#include "driftwise/v1/diagnosis_service.grpc.pb.h"
#include "server/application/diagnoses/diagnoses.h"
#include "server/application/diagnoses/extensions.h"
#include "server/application/improvement/improvements.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/plumbing/store_reader.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/diagnosis/diagnosis_html.h"
#include "server/formats/diagnosis/robot_names.h"
#include "server/formats/diagnosis/stored_diagnosis.h"
#include "server/rpc/configuration/convert_provenance.h"
#include "server/rpc/diagnosis/convert_diagnosis.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

constexpr int kListedImprovements = 200;

Result<formats::DiscrepancyRows> rows_of(Store& store, DiagnosisId id) {
  DRIFTWISE_TRY(const auto bytes, store.diagnoses().diagnosis_rows(id));
  return formats::read_discrepancy_rows(bytes);
}

// Thousands of rows become a message, and a page, on other threads than the executor.
Result<v1::DiscrepancyRows> rows_message_of(Store& store, DiagnosisId id) {
  DRIFTWISE_TRY(const auto rows, rows_of(store, id));
  return rows_from(rows);
}

std::string page_of(const application::DiagnosisView& view, const formats::DiscrepancyRows& rows) {
  auto found = *view.found;
  const auto dataset = formats::dataset_of(rows, found);
  std::string source;
  for (const RunId run : view.record.runs)
    source += (source.empty() ? "run " : ", ") + std::to_string(run.value);
  if (source.empty()) source = "a file";
  const auto robot = formats::robot_of_formula(view.record.baseline);
  if (!robot.empty()) source += ", robot " + robot;
  return formats::diagnosis_html(
      found, dataset,
      {"Diagnosis " + std::to_string(view.record.id.value) + " of " + source, source});
}

Result<std::string> page_text_of(const application::DiagnosisView& view,
                                 const formats::DiscrepancyRows& rows) {
  return utf8_from(page_of(view, rows));
}

class DiagnosisService final : public v1::DiagnosisService::CallbackService {
 public:
  explicit DiagnosisService(const application::Services& cell)
      : host_(cell.host),
        records_(cell.records),
        diagnoses_(cell.diagnoses),
        extensions_(cell.extensions),
        improvements_(cell.improvements) {}

  Reactor* CreateDiagnosis(Context* context, const v1::CreateDiagnosisRequest* request,
                           v1::CreateDiagnosisResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto asked, diagnosis_request_from(*request));
      auto creating = diagnoses_.create(caller_of(*context), std::move(asked));
      co_return put(co_await std::move(creating), *response->mutable_diagnosis());
    });
  }

  Reactor* GetDiagnosis(Context* context, const v1::GetDiagnosisRequest* request,
                        v1::GetDiagnosisResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->diagnosis_id(), "diagnosis_id"); !good) co_return good;
      const DiagnosisId id{request->diagnosis_id()};
      auto looking = diagnoses_.get(id);
      auto good = put(co_await std::move(looking), *response->mutable_diagnosis());
      if (!good || !request->with_rows()) co_return good;
      DRIFTWISE_CO_TRY(auto rows, co_await records_.call(rows_message_of, id));
      *response->mutable_rows() = std::move(rows);
      co_return Result<void>{};
    });
  }

  Reactor* ListDiagnoses(Context* context, const v1::ListDiagnosesRequest*,
                         v1::ListDiagnosesResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto views, co_await diagnoses_.list());
      for (const auto& view : views)
        *response->add_diagnoses() = diagnosis_from(view, DiagnosisDetail::summary);
      co_return Result<void>{};
    });
  }

  grpc::ServerWriteReactor<v1::WatchDiagnosisResponse>* WatchDiagnosis(
      Context*, const v1::WatchDiagnosisRequest* request) override {
    using Watch = Stream<v1::WatchDiagnosisResponse>;
    if (auto good = check_id(request->diagnosis_id(), "diagnosis_id"); !good)
      return refuse_stream<v1::WatchDiagnosisResponse>(good.error());
    return Watch::open(host_.executor(),
                       watch_diagnosis(host_, diagnoses_, DiagnosisId{request->diagnosis_id()}));
  }

  Reactor* CancelDiagnosis(Context* context, const v1::CancelDiagnosisRequest* request,
                           v1::CancelDiagnosisResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->diagnosis_id(), "diagnosis_id"); !good) co_return good;
      auto cancelling =
          diagnoses_.cancel(caller_of(*context), DiagnosisId{request->diagnosis_id()});
      co_return put(co_await std::move(cancelling), *response->mutable_diagnosis());
    });
  }

  Reactor* ExportDiagnosis(Context* context, const v1::ExportDiagnosisRequest* request,
                           v1::ExportDiagnosisResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->diagnosis_id(), "diagnosis_id"); !good) co_return good;
      const DiagnosisId id{request->diagnosis_id()};
      auto looking = diagnoses_.get(id);
      DRIFTWISE_CO_TRY(const auto view, co_await std::move(looking));
      if (!view.found)
        co_return fail(ErrorCode::failed_precondition, reasons::kNotDone,
                       "only a diagnosis that is done has a page");
      DRIFTWISE_CO_TRY(auto rows, co_await records_.call(rows_of, id));
      DRIFTWISE_CO_TRY(auto page, co_await application::run_on(host_.background(), page_text_of,
                                                               view, std::move(rows)));
      response->set_html(std::move(page));
      response->set_file_name("diagnosis_" + std::to_string(id.value) + ".html");
      co_return Result<void>{};
    });
  }

  Reactor* PreviewExtension(Context* context, const v1::PreviewExtensionRequest* request,
                            v1::PreviewExtensionResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      v1::AcceptExtensionRequest accepting;
      accepting.set_diagnosis_id(request->diagnosis_id());
      accepting.set_promote(request->promote());
      *accepting.mutable_finding_numbers() = request->finding_numbers();
      DRIFTWISE_CO_TRY(auto asked, accept_request_from(accepting));
      auto looking = extensions_.preview(std::move(asked));
      DRIFTWISE_CO_TRY(const auto preview, co_await std::move(looking));
      *response = preview_from(preview);
      co_return Result<void>{};
    });
  }

  Reactor* AcceptExtension(Context* context, const v1::AcceptExtensionRequest* request,
                           v1::AcceptExtensionResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto asked, accept_request_from(*request));
      auto accepting = extensions_.accept(caller_of(*context), std::move(asked));
      DRIFTWISE_CO_TRY(const auto made, co_await std::move(accepting));
      *response->mutable_extension() = extension_from(made);
      co_return Result<void>{};
    });
  }

  Reactor* UndoExtension(Context* context, const v1::UndoExtensionRequest* request,
                         v1::UndoExtensionResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->diagnosis_id(), "diagnosis_id"); !good) co_return good;
      auto undoing = extensions_.undo(caller_of(*context), DiagnosisId{request->diagnosis_id()});
      DRIFTWISE_CO_TRY(const auto undone, co_await std::move(undoing));
      *response->mutable_extension() = extension_from(undone);
      co_return Result<void>{};
    });
  }

  Reactor* CreateImprovement(Context* context, const v1::CreateImprovementRequest* request,
                             v1::CreateImprovementResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto asked, improve_request_from(*request));
      auto creating = improvements_.create(caller_of(*context), std::move(asked));
      co_return put(co_await std::move(creating), *response->mutable_improvement());
    });
  }

  Reactor* GetImprovement(Context* context, const v1::GetImprovementRequest* request,
                          v1::GetImprovementResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->improvement_id(), "improvement_id"); !good) co_return good;
      auto looking = records_.improvements().improvement(ImprovementId{request->improvement_id()});
      co_return put(co_await std::move(looking), *response->mutable_improvement());
    });
  }

  Reactor* ListImprovements(Context* context, const v1::ListImprovementsRequest*,
                            v1::ListImprovementsResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto records,
                       co_await records_.improvements().improvements(kListedImprovements));
      for (const auto& record : records) *response->add_improvements() = improvement_from(record);
      co_return Result<void>{};
    });
  }

  grpc::ServerWriteReactor<v1::WatchImprovementResponse>* WatchImprovement(
      Context*, const v1::WatchImprovementRequest* request) override {
    using Watch = Stream<v1::WatchImprovementResponse>;
    if (auto good = check_id(request->improvement_id(), "improvement_id"); !good)
      return refuse_stream<v1::WatchImprovementResponse>(good.error());
    return Watch::open(host_.executor(),
                       watch_improvement(host_, improvements_, records_,
                                         ImprovementId{request->improvement_id()}));
  }

  Reactor* CancelImprovement(Context* context, const v1::CancelImprovementRequest* request,
                             v1::CancelImprovementResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->improvement_id(), "improvement_id"); !good) co_return good;
      auto cancelling =
          improvements_.cancel(caller_of(*context), ImprovementId{request->improvement_id()});
      co_return put(co_await std::move(cancelling), *response->mutable_improvement());
    });
  }

 private:
  static Result<void> put(const Result<application::DiagnosisView>& view, v1::Diagnosis& out) {
    DRIFTWISE_RETURN_IF_ERROR(view);
    out = diagnosis_from(*view, DiagnosisDetail::whole);
    return {};
  }
  static Result<void> put(const Result<ImprovementRecord>& record, v1::Improvement& out) {
    DRIFTWISE_RETURN_IF_ERROR(record);
    out = improvement_from(*record);
    return {};
  }

  application::Host& host_;
  application::StoreReader& records_;
  application::Diagnoses& diagnoses_;
  application::Extensions& extensions_;
  application::Improvements& improvements_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_diagnosis_service(const application::Services& cell) {
  return std::make_unique<DiagnosisService>(cell);
}

}  // namespace driftwise::rpc
