#include <algorithm>
#include <cmath>

#include "driftwise/v1/commissioning_service.grpc.pb.h"
#include "server/application/commissioning/commissioning.h"
#include "server/application/manual/jogs.h"
#include "server/application/status/overview.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/commissioning/convert_commissioning.h"
#include "server/rpc/run/convert_run.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/request_times.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

constexpr int kMostThermometers = 200;

class CommissioningService final : public v1::CommissioningService::CallbackService {
 public:
  explicit CommissioningService(const application::Services& cell)
      : host_(cell.host),
        overview_(cell.overview),
        jogs_(cell.jogs),
        commissioning_(cell.commissioning) {}

  Reactor* CheckCell(Context* context, const v1::CheckCellRequest*,
                     v1::CheckCellResponse* response) override {
    return answer(host_, context, [this, context, response]() -> Awaitable<Result<void>> {
      auto checking = commissioning_.check(caller_of(*context));
      *response = check_from(co_await std::move(checking));
      co_return Result<void>{};
    });
  }

  Reactor* BeginJog(Context* context, const v1::BeginJogRequest* request,
                    v1::BeginJogResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (!std::isfinite(request->step_mm()))
        co_return fail(ErrorCode::invalid_argument, reasons::kNotFinite,
                       "step_mm: expected a finite number of mm");
      DRIFTWISE_CO_RETURN_IF_ERROR(check_size(request->channel(), kMostNameBytes, "channel"));
      DRIFTWISE_CO_TRY(auto answered, answer_from(request->answer()));
      application::JogOrder order;
      order.channel = request->channel();
      order.step_mm = request->step_mm();
      order.held = request->held();
      auto beginning = jogs_.begin(caller_of(*context), request->lease_token(), std::move(order),
                                   std::move(answered));
      DRIFTWISE_CO_TRY(const auto jog, co_await std::move(beginning));
      *response->mutable_jog() = jog_from(jog, overview_.description());
      co_return Result<void>{};
    });
  }

  Reactor* HoldJog(Context* context, const v1::HoldJogRequest* request,
                   v1::HoldJogResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto jog, jogs_.hold(request->jog_id(), request->lease_token()));
      *response->mutable_jog() = jog_from(jog, overview_.description());
      co_return Result<void>{};
    });
  }

  Reactor* EndJog(Context* context, const v1::EndJogRequest* request,
                  v1::EndJogResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      auto ending = jogs_.end(request->jog_id(), request->lease_token());
      DRIFTWISE_CO_TRY(const auto jog, co_await std::move(ending));
      *response->mutable_jog() = jog_from(jog, overview_.description());
      co_return Result<void>{};
    });
  }

  Reactor* CompareThermometers(Context* context, const v1::CompareThermometersRequest* request,
                               v1::CompareThermometersResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto range, range_from(*request, host_));
      if (request->channels_size() > kMostThermometers)
        co_return fail(ErrorCode::invalid_argument, reasons::kBadChannel,
                       "channels: more than 200 of them");
      std::vector<std::string> channels(request->channels().begin(), request->channels().end());
      auto comparing =
          commissioning_.compare_thermometers(range.from, range.to, std::move(channels));
      DRIFTWISE_CO_TRY(const auto report, co_await std::move(comparing));
      *response = thermometers_from(report, overview_.description());
      co_return Result<void>{};
    });
  }

  Reactor* BeginRest(Context* context, const v1::BeginRestRequest* request,
                     v1::BeginRestResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      application::RestLimits limits;
      if (request->has_length_limit_nm_per_h())
        limits.length_nm_per_h = request->length_limit_nm_per_h();
      if (request->has_temperature_limit_k_per_h())
        limits.temperature_k_per_h = request->temperature_limit_k_per_h();
      if (request->has_window_duration()) {
        DRIFTWISE_CO_TRY(const auto window,
                         nanoseconds_from(request->window_duration(), "window_duration"));
        limits.window_s = seconds_from(window);
      }
      auto beginning = commissioning_.begin_rest(caller_of(*context), limits);
      DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(beginning));
      co_return co_await show_rest(*response->mutable_rest());
    });
  }

  Reactor* EndRest(Context* context, const v1::EndRestRequest*,
                   v1::EndRestResponse* response) override {
    return answer(host_, context, [this, context, response]() -> Awaitable<Result<void>> {
      auto ending = commissioning_.end_rest(caller_of(*context));
      DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(ending));
      co_return co_await show_rest(*response->mutable_rest());
    });
  }

  Reactor* GetRest(Context* context, const v1::GetRestRequest*,
                   v1::GetRestResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      co_return co_await show_rest(*response->mutable_rest());
    });
  }

  Reactor* ListCertificates(Context* context, const v1::ListCertificatesRequest*,
                            v1::ListCertificatesResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      const auto states = commissioning_.certificates();
      for (const auto& one : states) *response->add_certificates() = certificate_from(one);
      for (const auto& device : overview_.description().devices) {
        const auto role = device.role();
        const bool measures = measures_pose(role) || role == DeviceRole::temperature ||
                              role == DeviceRole::force || role == DeviceRole::environment;
        const bool has = std::ranges::any_of(
            states, [&device](const auto& one) { return one.certificate.device == device.id; });
        if (measures && !has) response->add_without(utf8_from(device.id));
      }
      co_return Result<void>{};
    });
  }

 private:
  Awaitable<Result<void>> show_rest(v1::Rest& out) {
    auto asking = commissioning_.rest();
    DRIFTWISE_CO_TRY(const auto report, co_await std::move(asking));
    out = rest_from(report);
    co_return Result<void>{};
  }

  application::Host& host_;
  application::Overview& overview_;
  application::Jogs& jogs_;
  application::Commissioning& commissioning_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_commissioning_service(const application::Services& cell) {
  return std::make_unique<CommissioningService>(cell);
}

}  // namespace driftwise::rpc
