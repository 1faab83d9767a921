#include <algorithm>

#include "driftwise/v1/model_service.grpc.pb.h"
#include "server/application/analyses/studies.h"
#include "server/application/checks/model_checks.h"
#include "server/application/models/models.h"
#include "server/application/models/promotions.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/provenance/provenance.h"
#include "server/application/status/overview.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/model/model_json.h"
#include "server/rpc/configuration/convert_provenance.h"
#include "server/rpc/model/convert_check.h"
#include "server/rpc/model/convert_model.h"
#include "server/rpc/model/convert_residuals.h"
#include "server/rpc/model/convert_study.h"
#include "server/rpc/model/export_model.h"
#include "server/rpc/model/fit_request.h"
#include "server/rpc/model/model_budget.h"
#include "server/rpc/model/study_source.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"
#include "server/rpc/shared/wire_time.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

class ModelService final : public v1::ModelService::CallbackService {
 public:
  explicit ModelService(const application::Services& cell)
      : host_(cell.host),
        overview_(cell.overview),
        records_(cell.records),
        models_(cell.models),
        promotions_(cell.promotions),
        checks_(cell.checks),
        provenance_(cell.provenance),
        studies_(cell.studies) {}

  Reactor* GetModel(Context* context, const v1::GetModelRequest* request,
                    v1::GetModelResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->model_id(), "model_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(const auto record, co_await models_.get(ModelId{request->model_id()}));
      if (auto good = put(whole(record), *response->mutable_model()); !good) co_return good;
      auto looking = provenance_.ground_of_model(record.id);
      DRIFTWISE_CO_TRY(const auto ground, co_await std::move(looking));
      add_page(record, ground, *response);
      co_return Result<void>{};
    });
  }

  Reactor* ListModels(Context* context, const v1::ListModelsRequest*,
                      v1::ListModelsResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto models, co_await models_.list());
      const auto serving = overview_.status().serving;
      DRIFTWISE_CO_TRY(const auto corrections, co_await records_.extensions().corrections());
      for (const auto& listed : models) {
        auto& model = *response->add_models();
        model = model_from(listed, serving);
        const auto& named = listed.record.corrections;
        for (const auto& correction : corrections)
          if (std::ranges::find(named, correction.id) != named.end())
            *model.add_corrections() = mark_from(correction);
      }
      co_return Result<void>{};
    });
  }

  Reactor* ListPromotions(Context* context, const v1::ListPromotionsRequest*,
                          v1::ListPromotionsResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto promotions, co_await records_.models().promotions());
      for (const auto& promotion : promotions)
        *response->add_promotions() = promotion_from(promotion);
      co_return Result<void>{};
    });
  }

  Reactor* CreateFit(Context* context, const v1::CreateFitRequest* request,
                     v1::CreateFitResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto fit, fit_request_from(*request));
      if (request->with_offers()) {  // first: a model whose offers cannot be weighed is not stored
        DRIFTWISE_CO_TRY(const auto offers, co_await models_.weigh_offers(fit));
        for (const auto& offer : offers) *response->add_offers() = offer_from(offer);
      }
      co_return put(whole(co_await models_.fit(caller_of(*context), std::move(fit))),
                    *response->mutable_model());
    });
  }

  Reactor* CreateKinematicModel(Context* context, const v1::CreateKinematicModelRequest* request,
                                v1::CreateKinematicModelResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto asked, kinematic_request_from(*request));
      auto making = models_.create_kinematic(caller_of(*context), std::move(asked));
      DRIFTWISE_CO_TRY(const auto made, co_await std::move(making));
      for (const auto& finding : made.findings) response->add_findings(utf8_from(finding));
      co_return put(whole(made.model), *response->mutable_model());
    });
  }

  Reactor* CompareModels(Context* context, const v1::CompareModelsRequest* request,
                         v1::CompareModelsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (request->model_ids_size() < 2 || request->model_ids_size() > 16)
        co_return fail(ErrorCode::invalid_argument, reasons::kBadModelCount,
                       "model_ids: found " + std::to_string(request->model_ids_size()) +
                           " models, expected 2 to 16");
      std::vector<v1::Model> models;
      std::optional<ModelRecord> first;
      for (const std::int64_t id : request->model_ids()) {
        if (auto good = check_id(id, "model_id"); !good) co_return good;
        auto record = co_await models_.get(ModelId{id});
        if (!first && record) first = *record;
        DRIFTWISE_CO_TRY(auto model, whole(record, first ? &*first : nullptr));
        models.push_back(std::move(model));
      }
      *response = comparison_of(models);
      co_return Result<void>{};
    });
  }

  Reactor* PromoteModel(Context* context, const v1::PromoteModelRequest* request,
                        v1::PromoteModelResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->model_id(), "model_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(auto reason, line_from(request->reason(), kMostNoteBytes, "reason"));
      if (reason.find_first_not_of(' ') == std::string::npos) reason.clear();
      std::optional<application::Promotions::Seen> seen;
      if (request->has_serving_model_id()) {
        const std::int64_t serving = request->serving_model_id();
        if (auto good = check_id(serving, "serving_model_id"); serving != 0 && !good)
          co_return good;
        seen.emplace();
        if (serving != 0) seen->serving = ModelId{serving};
      }
      std::optional<ModelRecord> before;
      if (const auto serving = overview_.status().serving)
        if (auto record = co_await models_.get(*serving)) before = std::move(*record);
      auto promoting = promotions_.promote(caller_of(*context), ModelId{request->model_id()},
                                           request->confirmed(), std::move(reason), seen);
      const auto promoted = co_await std::move(promoting);
      co_return put(whole(promoted, before ? &*before : nullptr), *response->mutable_model());
    });
  }

  Reactor* RollBackModel(Context* context, const v1::RollBackModelRequest* request,
                         v1::RollBackModelResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      std::optional<ModelId> from;
      if (request->has_serving_model_id()) from = ModelId{request->serving_model_id()};
      auto rolling = promotions_.roll_back(caller_of(*context), from);
      DRIFTWISE_CO_TRY(const auto record, co_await std::move(rolling));
      if (!record) co_return Result<void>{};
      co_return put(whole(*record), *response->mutable_model());
    });
  }

  Reactor* ExportModel(Context* context, const v1::ExportModelRequest* request,
                       v1::ExportModelResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->model_id(), "model_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(const auto record, co_await models_.get(ModelId{request->model_id()}));
      auto reading = records_.audit().head();
      DRIFTWISE_CO_TRY(const auto head, co_await std::move(reading));
      co_return put(export_model(record, request->format(), head.entry > 0 ? to_string(head) : "",
                                 to_iso8601(utc_from(host_.now()))),
                    *response);
    });
  }

  Reactor* CheckModel(Context* context, const v1::CheckModelRequest* request,
                      v1::CheckModelResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_cursor(request->model_id(), "model_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(auto runs, run_ids_from(request->run_ids()));
      const auto model =
          request->model_id() == 0 ? std::nullopt : std::optional(ModelId{request->model_id()});
      auto checking = checks_.check_model(model, std::move(runs));
      DRIFTWISE_CO_TRY(const auto check, co_await std::move(checking));
      *response = check_from(check);
      co_return Result<void>{};
    });
  }

  Reactor* CheckFormula(Context* context, const v1::CheckFormulaRequest* request,
                        v1::CheckFormulaResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto fit, fit_request_from(request->fit()));
      DRIFTWISE_CO_TRY(const auto check, co_await models_.check_formula(std::move(fit)));
      *response = formula_check_from(check);
      co_return Result<void>{};
    });
  }

  Reactor* ListResiduals(Context* context, const v1::ListResidualsRequest* request,
                         v1::ListResidualsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->model_id(), "model_id"); !good) co_return good;
      if (auto good = check_size(request->csv(), kMostDatasetBytes, "csv"); !good) co_return good;
      DRIFTWISE_CO_TRY(auto runs, run_ids_from(request->run_ids()));
      auto asking =
          models_.residuals(ModelId{request->model_id()}, std::move(runs), request->csv());
      DRIFTWISE_CO_TRY(auto residuals, co_await std::move(asking));
      *response =
          co_await application::run_on(host_.background(), residuals_from, std::move(residuals));
      co_return Result<void>{};
    });
  }

  grpc::ServerWriteReactor<v1::CompareMethodsResponse>* CompareMethods(
      Context*, const v1::CompareMethodsRequest* request) override {
    using Response = v1::CompareMethodsResponse;
    auto asked = methods_request_from(*request);
    if (!asked) return refuse_stream<Response>(asked.error());
    return Stream<Response>::open(
        host_.executor(), std::make_unique<StudySource<Response>>(
                              host_.executor(), [this, wanted = std::move(*asked)](auto study) {
                                return compared(wanted, std::move(study));
                              }));
  }

  grpc::ServerWriteReactor<v1::StudySensorsResponse>* StudySensors(
      Context*, const v1::StudySensorsRequest* request) override {
    using Response = v1::StudySensorsResponse;
    auto asked = sensors_request_from(*request);
    if (!asked) return refuse_stream<Response>(asked.error());
    return Stream<Response>::open(
        host_.executor(), std::make_unique<StudySource<Response>>(
                              host_.executor(), [this, wanted = std::move(*asked)](auto study) {
                                return sensors_chosen(wanted, std::move(study));
                              }));
  }

 private:
  Awaitable<Result<v1::CompareMethodsResponse>> compared(
      application::MethodsRequest asked, std::shared_ptr<application::Study> study) {
    const std::string formula = asked.fit.formula;
    auto comparing = studies_.compare_methods(std::move(asked), std::move(study));
    DRIFTWISE_CO_TRY(const auto judgements, co_await std::move(comparing));
    co_return comparison_from(judgements, formula);
  }

  Awaitable<Result<v1::StudySensorsResponse>> sensors_chosen(
      application::SensorsRequest asked, std::shared_ptr<application::Study> study) {
    auto choosing = studies_.study_sensors(std::move(asked), std::move(study));
    DRIFTWISE_CO_TRY(const auto choice, co_await std::move(choosing));
    co_return sensor_choice_from(choice);
  }

  Result<v1::Model> whole(const Result<ModelRecord>& record,
                          const ModelRecord* before = nullptr) const {
    DRIFTWISE_RETURN_IF_ERROR(record);
    return model_from(*record, overview_.status().serving, ModelDetail::whole, before);
  }

  // What its page says beyond the model. It could be read: whole() did.
  // The cell file that the model was measured under. A model of a file has none: no instrument is
  // declared for its rows, and the budget is that of a target here.
  void add_page(const ModelRecord& record, const application::ModelGround& ground,
                v1::GetModelResponse& response) const {
    const bool is_of_a_file = ground.configurations.empty();
    add_ground(ground, response);
    if (!is_of_a_file && !ground.measured_under) return;  // no text of it can be read
    const auto& description = is_of_a_file ? overview_.description() : *ground.measured_under;
    response.set_cell_name(description.name);
    if (!is_of_a_file) add_declared(description, response);
    if (const auto model = formats::read_model_json(record.json))
      add_budgets(*model, description, response);
  }

  template <class Message>
  static Result<void> put(Result<Message> found, Message& out) {
    DRIFTWISE_RETURN_IF_ERROR(found);
    out = std::move(*found);
    return {};
  }

  application::Host& host_;
  application::Overview& overview_;
  application::StoreReader& records_;
  application::Models& models_;
  application::Promotions& promotions_;
  application::ModelChecks& checks_;
  application::Provenance& provenance_;
  application::Studies& studies_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_model_service(const application::Services& cell) {
  return std::make_unique<ModelService>(cell);
}

}  // namespace driftwise::rpc
