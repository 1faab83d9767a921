#include "driftwise/v1/indentation_service.grpc.pb.h"
#include "server/application/indentations/indentations.h"
#include "server/core/try.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;
using application::Indentations;

v1::IndentConformity conformity_from(indentation::Conformity conformity) {
  switch (conformity) {
    case indentation::Conformity::within:
      return v1::INDENT_CONFORMITY_WITHIN;
    case indentation::Conformity::beyond:
      return v1::INDENT_CONFORMITY_BEYOND;
    case indentation::Conformity::undecided:
      return v1::INDENT_CONFORMITY_UNDECIDED;
  }
  return v1::INDENT_CONFORMITY_UNSPECIFIED;
}

v1::Indentation indentation_from(const application::IndentationView& view) {
  v1::Indentation out;
  out.set_id(view.record.id.value);
  out.set_name(utf8_from(view.name));
  out.set_tool(utf8_from(view.tool));
  out.set_stage(view.stage);
  out.set_contact_count(view.contacts);
  out.set_indent_count(view.made);
  out.set_planned_indent_count(view.planned);
  out.set_in_contact(view.in_contact);
  out.set_ended(utf8_from(view.record.ended));
  *out.mutable_create_time() = timestamp_from(view.record.created);
  *out.mutable_report_time() = timestamp_from(view.record.reported);
  out.set_created_by(utf8_from(view.record.created_by));
  out.set_verdict(utf8_from(view.verdict));
  if (view.conformity) out.set_conformity(conformity_from(*view.conformity));
  out.set_key(utf8_from(view.record.key));
  return out;
}

class IndentationService final : public v1::IndentationService::CallbackService {
 public:
  explicit IndentationService(const application::Services& cell)
      : host_(cell.host), indentations_(cell.indentations) {}

  Reactor* CreateIndentation(Context* context, const v1::CreateIndentationRequest* request,
                             v1::CreateIndentationResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      for (const auto& good :
           {check_size(request->key(), Indentations::kMostKeyBytes, "key"),
            check_size(request->file_text(), Indentations::kMostFileBytes, "file_text"),
            check_size(request->record_json(), Indentations::kMostRecordBytes, "record_json")})
        if (!good) co_return good;
      auto beginning = indentations_.begin(caller_of(*context), request->key(),
                                           request->file_text(), request->record_json());
      DRIFTWISE_CO_TRY(const auto view, co_await std::move(beginning));
      *response->mutable_indentation() = indentation_from(view);
      co_return Result<void>{};
    });
  }

  Reactor* ReportIndentation(Context* context, const v1::ReportIndentationRequest* request,
                             v1::ReportIndentationResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_RETURN_IF_ERROR(check_id(request->indentation_id(), "indentation_id"));
      DRIFTWISE_CO_RETURN_IF_ERROR(
          check_size(request->record_json(), Indentations::kMostRecordBytes, "record_json"));
      DRIFTWISE_CO_RETURN_IF_ERROR(check_size(request->ended(), kMostNoteBytes, "ended"));
      auto reporting = indentations_.report(caller_of(*context), {request->indentation_id()},
                                            request->record_json(), clean_line(request->ended()));
      DRIFTWISE_CO_TRY(const auto view, co_await std::move(reporting));
      *response->mutable_indentation() = indentation_from(view);
      co_return Result<void>{};
    });
  }

  Reactor* ImportIndentTable(Context* context, const v1::ImportIndentTableRequest* request,
                             v1::ImportIndentTableResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_RETURN_IF_ERROR(check_id(request->indentation_id(), "indentation_id"));
      DRIFTWISE_CO_RETURN_IF_ERROR(
          check_size(request->microscope_csv(), Indentations::kMostRecordBytes, "microscope_csv"));
      auto importing = indentations_.import_table(caller_of(*context), {request->indentation_id()},
                                                  request->microscope_csv());
      DRIFTWISE_CO_TRY(const auto view, co_await std::move(importing));
      *response->mutable_indentation() = indentation_from(view);
      response->set_table_json(view.table_json);
      co_return Result<void>{};
    });
  }

  Reactor* ListIndentations(Context* context, const v1::ListIndentationsRequest* request,
                            v1::ListIndentationsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto limit, limit_from(request->limit(), 100, 1000));
      auto listing = indentations_.list(limit);
      DRIFTWISE_CO_TRY(const auto views, co_await std::move(listing));
      for (const auto& view : views) *response->add_indentations() = indentation_from(view);
      co_return Result<void>{};
    });
  }

  Reactor* GetIndentation(Context* context, const v1::GetIndentationRequest* request,
                          v1::GetIndentationResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_RETURN_IF_ERROR(check_id(request->indentation_id(), "indentation_id"));
      auto getting = indentations_.get({request->indentation_id()});
      DRIFTWISE_CO_TRY(const auto view, co_await std::move(getting));
      *response->mutable_indentation() = indentation_from(view);
      response->set_file_text(utf8_from(view.record.file_text));
      response->set_record_json(utf8_from(view.record.record_json));
      response->set_table_json(view.table_json);
      response->set_table_trouble(utf8_from(view.table_trouble));
      co_return Result<void>{};
    });
  }

 private:
  application::Host& host_;
  Indentations& indentations_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_indentation_service(const application::Services& cell) {
  return std::make_unique<IndentationService>(cell);
}

}  // namespace driftwise::rpc
