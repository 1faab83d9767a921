#include "driftwise/v1/configuration_service.grpc.pb.h"
#include "server/application/configuration/configurations.h"
#include "server/application/plumbing/store_reader.h"
#include "server/core/text/clean_text.h"
#include "server/core/try.h"
#include "server/formats/cell_file/without_secrets.h"
#include "server/rpc/configuration/convert_provenance.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

class ConfigurationService final : public v1::ConfigurationService::CallbackService {
 public:
  explicit ConfigurationService(const application::Services& cell)
      : host_(cell.host), records_(cell.records), configurations_(cell.configurations) {}

  Reactor* ListConfigurations(Context* context, const v1::ListConfigurationsRequest* request,
                              v1::ListConfigurationsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto limit, limit_from(request->limit(), 100, 1000));
      auto reading = records_.configurations().starts(limit);
      DRIFTWISE_CO_TRY(const auto starts, co_await std::move(reading));
      for (const auto& start : starts) *response->add_starts() = start_from(start);
      response->set_open_question(!starts.empty() && starts.front().is_open());
      co_return Result<void>{};
    });
  }

  Reactor* GetConfiguration(Context* context, const v1::GetConfigurationRequest* request,
                            v1::GetConfigurationResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      for (const auto& good : {check_size(request->hash(), kMostNameBytes, "hash"),
                               check_size(request->compare_hash(), kMostNameBytes, "compare_hash")})
        if (!good) co_return good;
      auto reading = configurations_.get(request->hash(), request->compare_hash());
      DRIFTWISE_CO_TRY(const auto view, co_await std::move(reading));
      response->set_hash(view.hash);
      // The support bundle has the same text without secrets, for engineers.
      const bool whole = access::includes(identity_of(*context).role, access::Role::admin);
      response->set_text(whole ? view.text : formats::cell_file_without_secrets(view.text));
      response->set_compared_hash(view.compared_hash);
      for (const auto& change : view.changes) *response->add_changes() = change_from(change);
      co_return Result<void>{};
    });
  }

  Reactor* AcceptConfiguration(Context* context, const v1::AcceptConfigurationRequest* request,
                               v1::AcceptConfigurationResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      for (const auto& good : {check_size(request->hash(), kMostNameBytes, "hash"),
                               check_size(request->note(), kMostNoteBytes, "note")})
        if (!good) co_return good;
      auto accepting =
          configurations_.accept(caller_of(*context), request->hash(), clean_line(request->note()));
      DRIFTWISE_CO_TRY(const auto accepted, co_await std::move(accepting));
      *response->mutable_start() = start_from(accepted);
      co_return Result<void>{};
    });
  }

 private:
  application::Host& host_;
  application::StoreReader& records_;
  application::Configurations& configurations_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_configuration_service(const application::Services& cell) {
  return std::make_unique<ConfigurationService>(cell);
}

}  // namespace driftwise::rpc
