#include <cmath>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "server/application/holds/holds.h"
#include "server/application/manual/manual_control.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/status/overview.h"
#include "server/application/watching/feeds.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/cell/convert_cell.h"
#include "server/rpc/cell/motor_coordinates.h"
#include "server/rpc/run/convert_run.h"
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

v1::StabiliserTuning tuning_from(const LoopTuning& tuning) {
  v1::StabiliserTuning out;
  if (tuning.heat_band_k) out.set_heat_band_k(*tuning.heat_band_k);
  if (tuning.cool_band_k) out.set_cool_band_k(*tuning.cool_band_k);
  if (tuning.integral_s) *out.mutable_integral_duration() = duration_from_s(*tuning.integral_s);
  if (tuning.derivative_s)
    *out.mutable_derivative_duration() = duration_from_s(*tuning.derivative_s);
  return out;
}

Result<LoopTuning> wanted_tuning(const v1::StabiliserTuning& tuning) {
  LoopTuning out;
  if (tuning.has_heat_band_k()) out.heat_band_k = tuning.heat_band_k();
  if (tuning.has_cool_band_k()) out.cool_band_k = tuning.cool_band_k();
  if (tuning.has_integral_duration()) {
    DRIFTWISE_TRY(const auto time, nanoseconds_from(tuning.integral_duration(), "integral"));
    out.integral_s = seconds_from(time);
  }
  if (tuning.has_derivative_duration()) {
    DRIFTWISE_TRY(const auto time, nanoseconds_from(tuning.derivative_duration(), "derivative"));
    out.derivative_s = seconds_from(time);
  }
  for (const auto& value : {out.heat_band_k, out.cool_band_k})
    if (value && !std::isfinite(*value))
      return fail(ErrorCode::invalid_argument, reasons::kNotFinite,
                  "tuning: expected a finite band in K");
  return out;
}

class CellService final : public v1::CellService::CallbackService {
 public:
  explicit CellService(const application::Services& cell)
      : host_(cell.host),
        overview_(cell.overview),
        records_(cell.records),
        manual_(cell.manual),
        holds_(cell.holds),
        feeds_(cell.feeds) {}

  Reactor* GetStatus(Context* context, const v1::GetStatusRequest*,
                     v1::GetStatusResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      *response = status_from(overview_.status());
      co_return Result<void>{};
    });
  }

  Reactor* ListDevices(Context* context, const v1::ListDevicesRequest*,
                       v1::ListDevicesResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      for (const auto& device : overview_.status().devices)
        *response->add_devices() = device_from(device);
      for (const auto& setup : overview_.description().setups)
        response->add_setup_names(utf8_from(setup.name));
      co_return Result<void>{};
    });
  }

  Reactor* ListEvents(Context* context, const v1::ListEventsRequest* request,
                      v1::ListEventsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_cursor(request->after_event_id(), "after_event_id"); !good)
        co_return good;
      DRIFTWISE_CO_TRY(const auto limit, limit_from(request->limit(), 100, 1000));
      DRIFTWISE_CO_TRY(const auto events, co_await records_.events().events(
                                              EventId{request->after_event_id()}, limit));
      for (const auto& event : events) *response->add_events() = event_from(event);
      co_return Result<void>{};
    });
  }

  Reactor* TakeLease(Context* context, const v1::TakeLeaseRequest* request,
                     v1::TakeLeaseResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      Nanoseconds duration = std::chrono::seconds(60);
      if (request->has_lease_duration()) {
        DRIFTWISE_CO_TRY(const auto asked,
                         nanoseconds_from(request->lease_duration(), "lease_duration"));
        duration = asked;
      }
      DRIFTWISE_CO_TRY(const auto lease,
                       manual_.take_lease(caller_of(*context), duration, request->token()));
      *response->mutable_lease() = lease_from(lease);
      co_return Result<void>{};
    });
  }

  Reactor* GiveUpLease(Context* context, const v1::GiveUpLeaseRequest* request,
                       v1::GiveUpLeaseResponse*) override {
    return answer(host_, context, [this, context, request]() -> Awaitable<Result<void>> {
      co_return manual_.give_up_lease(caller_of(*context), request->token());
    });
  }

  Reactor* StopAll(Context* context, const v1::StopAllRequest*,
                   v1::StopAllResponse* response) override {
    return answer(host_, context, [this, context, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto answered, co_await manual_.stop_all(caller_of(*context)));
      response->set_confirmed(answered.confirmed);
      response->set_message(utf8_from(answered.message));
      for (const auto& stop : answered.pending) *response->add_pending() = pending_stop_from(stop);
      co_return Result<void>{};
    });
  }

  Reactor* Home(Context* context, const v1::HomeRequest* request, v1::HomeResponse*) override {
    return answer(host_, context, [this, context, request]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto answered, answer_from(request->answer()));
      auto homing = manual_.home(caller_of(*context), request->lease_token(), std::move(answered));
      co_return co_await std::move(homing);
    });
  }

  Reactor* Move(Context* context, const v1::MoveRequest* request, v1::MoveResponse*) override {
    return answer(host_, context, [this, context, request]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto q_mm,
                       motor_coordinates_from(request->coordinates(), overview_.description()));
      DRIFTWISE_CO_TRY(auto answered, answer_from(request->answer()));
      auto moving = manual_.move_to(caller_of(*context), request->lease_token(), std::move(q_mm),
                                    std::move(answered));
      co_return co_await std::move(moving);
    });
  }

  Reactor* SetStabiliser(Context* context, const v1::SetStabiliserRequest* request,
                         v1::SetStabiliserResponse*) override {
    return answer(host_, context, [this, context, request]() -> Awaitable<Result<void>> {
      if (!request->has_set_point_degc() || !std::isfinite(request->set_point_degc()))
        co_return fail(ErrorCode::invalid_argument, reasons::kNotFinite,
                       "set_point_degc: expected a finite number of degC");
      co_return co_await manual_.set_stabiliser(caller_of(*context), request->lease_token(),
                                                request->device_id(), request->set_point_degc());
    });
  }

  Reactor* GetStabiliser(Context* context, const v1::GetStabiliserRequest* request,
                         v1::GetStabiliserResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_RETURN_IF_ERROR(check_size(request->device_id(), kMostNameBytes, "device_id"));
      auto asking = manual_.stabiliser_tuning(request->device_id());
      DRIFTWISE_CO_TRY(const auto tuning, co_await std::move(asking));
      *response->mutable_tuning() = tuning_from(tuning.now);
      response->set_settled_band_k(overview_.description().checks.stabiliser_band_k);
      if (!tuning.declared.empty()) *response->mutable_declared() = tuning_from(tuning.declared);
      for (auto& sentence : differences_of(tuning.declared, tuning.now))
        response->add_differences(std::move(sentence));
      co_return Result<void>{};
    });
  }

  Reactor* TuneStabiliser(Context* context, const v1::TuneStabiliserRequest* request,
                          v1::TuneStabiliserResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_RETURN_IF_ERROR(check_size(request->device_id(), kMostNameBytes, "device_id"));
      DRIFTWISE_CO_TRY(const auto wanted, wanted_tuning(request->tuning()));
      auto tuning = manual_.tune_stabiliser(caller_of(*context), request->lease_token(),
                                            request->device_id(), wanted);
      DRIFTWISE_CO_TRY(const auto tuned, co_await std::move(tuning));
      *response->mutable_before() = tuning_from(tuned.before);
      *response->mutable_after() = tuning_from(tuned.after);
      co_return Result<void>{};
    });
  }

  Reactor* ListHolds(Context* context, const v1::ListHoldsRequest*,
                     v1::ListHoldsResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      for (const auto& hold : holds_.list()) *response->add_holds() = hold_from(hold);
      co_return Result<void>{};
    });
  }

  Reactor* SetHoldAside(Context* context, const v1::SetHoldAsideRequest* request,
                        v1::SetHoldAsideResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_RETURN_IF_ERROR(check_size(request->name(), kMostNameBytes, "name"));
      DRIFTWISE_CO_RETURN_IF_ERROR(check_size(request->reason(), kMostNameBytes, "reason"));
      DRIFTWISE_CO_TRY(const auto aside,
                       nanoseconds_from(request->aside_duration(), "aside_duration"));
      auto setting = holds_.set_aside(caller_of(*context), request->name(), seconds_from(aside),
                                      request->reason());
      DRIFTWISE_CO_TRY(const auto hold, co_await std::move(setting));
      *response->mutable_hold() = hold_from(hold);
      co_return Result<void>{};
    });
  }

  grpc::ServerWriteReactor<v1::WatchEventsResponse>* WatchEvents(
      Context*, const v1::WatchEventsRequest* request) override {
    std::optional<EventId> after;
    if (request->has_after_event_id()) {
      if (auto good = check_cursor(request->after_event_id(), "after_event_id"); !good)
        return refuse_stream<v1::WatchEventsResponse>(good.error());
      after = EventId{request->after_event_id()};
    }
    return Stream<v1::WatchEventsResponse>::open(host_.executor(),
                                                 watch_events(host_, feeds_, records_, after));
  }

  grpc::ServerWriteReactor<v1::WatchReadingsResponse>* WatchReadings(
      Context*, const v1::WatchReadingsRequest* request) override {
    if (!request->device_id().empty() &&
        overview_.description().find_device(request->device_id()) == nullptr)
      return refuse_stream<v1::WatchReadingsResponse>({ErrorCode::not_found, reasons::kNoDevice,
                                                       "device_id: this cell has no device '" +
                                                           request->device_id() +
                                                           "': 'driftwise devices' lists them"});
    return Stream<v1::WatchReadingsResponse>::open(host_.executor(),
                                                   watch_readings(feeds_, request->device_id()));
  }

 private:
  application::Host& host_;
  application::Overview& overview_;
  application::StoreReader& records_;
  application::ManualControl& manual_;
  application::Holds& holds_;
  application::Feeds& feeds_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_cell_service(const application::Services& cell) {
  return std::make_unique<CellService>(cell);
}

}  // namespace driftwise::rpc
