#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/asio/thread_pool.hpp>

#include "driftwise/v1/watch_service.grpc.pb.h"
#include "server/application/alarms/alarms.h"
#include "server/application/notify/notifications.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/runs/runs.h"
#include "server/application/status/overview.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"
#include "server/rpc/watch/convert_watch.h"
#include "server/rpc/watch/series_request.h"
#include "server/rpc/watch/watch_batches.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

// Streams have a thread of their own: what clients cost is not the cell's.
class WatchService final : public v1::WatchService::CallbackService {
 public:
  explicit WatchService(const application::Services& cell)
      : host_(cell.host),
        overview_(cell.overview),
        records_(cell.records),
        runs_(cell.runs),
        alarms_(cell.alarms),
        notifications_(cell.notifications),
        feed_(std::make_shared<WatchFeed>(cell, thread_.get_executor())) {}
  ~WatchService() override { thread_.join(); }

  grpc::ServerWriteReactor<v1::WatchResponse>* Watch(Context*,
                                                     const v1::WatchRequest* request) override {
    auto wish = watch_wish_from(*request);
    if (!wish) return refuse_stream<v1::WatchResponse>(wish.error());
    return Stream<v1::WatchResponse>::open(feed_->executor(),
                                           watch_batches(feed_, std::move(*wish)));
  }

  Reactor* GetSeries(Context* context, const v1::GetSeriesRequest* request,
                     v1::GetSeriesResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      auto making = series_query_from(*request, host_, runs_);
      DRIFTWISE_CO_TRY(auto query, co_await std::move(making));
      auto asking = records_.series().series(std::move(query));
      DRIFTWISE_CO_TRY(const auto series, co_await std::move(asking));
      *response->mutable_from_time() = timestamp_from(series.from);
      *response->mutable_to_time() = timestamp_from(series.to);
      *response->mutable_bucket_duration() = duration_from(series.bucket);
      bool raw = true;
      const auto unknown = unknown_channels(series);
      if (unknown.size() == series.columns.size())
        co_return fail(ErrorCode::invalid_argument, reasons::kNoSuchChannel,
                       "channels: found " + fmt::format("{}", fmt::join(unknown, ", ")) +
                           ", which no device of this cell gives and which this database does not "
                           "hold: 'driftwise readings' lists the channels");
      for (const auto& name : unknown) response->add_unknown_channels(utf8_from(name));
      for (const auto& column : series.columns) {
        if (std::find(unknown.begin(), unknown.end(), column.channel) != unknown.end()) continue;
        *response->add_series() = series_from(column);
        for (const std::int64_t count : column.count) raw = raw && count <= 1;
      }
      response->set_raw(raw);
      co_return Result<void>{};
    });
  }

  Reactor* ListAlarms(Context* context, const v1::ListAlarmsRequest* request,
                      v1::ListAlarmsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      constexpr int kMost = 500;
      auto asking = alarms_.list(request->with_history(), kMost);
      DRIFTWISE_CO_TRY(const auto alarms, co_await std::move(asking));
      for (const auto& alarm : alarms) *response->add_alarms() = alarm_from(alarm);
      co_return Result<void>{};
    });
  }

  Reactor* AcknowledgeAlarm(Context* context, const v1::AcknowledgeAlarmRequest* request,
                            v1::AcknowledgeAlarmResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->alarm_id(), "alarm_id"); !good) co_return good;
      auto asking = alarms_.acknowledge(caller_of(*context), AlarmId{request->alarm_id()});
      DRIFTWISE_CO_TRY(const auto alarm, co_await std::move(asking));
      *response->mutable_alarm() = alarm_from(alarm);
      co_return Result<void>{};
    });
  }

  Reactor* ShelveAlarm(Context* context, const v1::ShelveAlarmRequest* request,
                       v1::ShelveAlarmResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->alarm_id(), "alarm_id"); !good) co_return good;
      const auto& duration = request->shelve_duration();
      const double for_s =
          static_cast<double>(duration.seconds()) + 1e-9 * static_cast<double>(duration.nanos());
      DRIFTWISE_CO_TRY(auto reason, line_from(request->reason(), kMostNoteBytes, "reason"));
      auto asking = alarms_.shelve(caller_of(*context), AlarmId{request->alarm_id()}, for_s,
                                   std::move(reason));
      DRIFTWISE_CO_TRY(const auto alarm, co_await std::move(asking));
      *response->mutable_alarm() = alarm_from(alarm);
      co_return Result<void>{};
    });
  }

  Reactor* UnshelveAlarm(Context* context, const v1::UnshelveAlarmRequest* request,
                         v1::UnshelveAlarmResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->alarm_id(), "alarm_id"); !good) co_return good;
      auto asking = alarms_.unshelve(caller_of(*context), AlarmId{request->alarm_id()});
      DRIFTWISE_CO_TRY(const auto alarm, co_await std::move(asking));
      *response->mutable_alarm() = alarm_from(alarm);
      co_return Result<void>{};
    });
  }

  Reactor* ListReceivers(Context* context, const v1::ListReceiversRequest* request,
                         v1::ListReceiversResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      constexpr int kUsual = 100, kMost = 1000;
      for (const auto& one : notifications_.receivers())
        *response->add_receivers() = receiver_from(one);
      const int limit = request->limit() > 0 ? std::min(request->limit(), kMost) : kUsual;
      auto asking = notifications_.tellings(limit);
      DRIFTWISE_CO_TRY(const auto tellings, co_await std::move(asking));
      for (const auto& one : tellings) *response->add_tellings() = telling_from(one);
      co_return Result<void>{};
    });
  }

  Reactor* TestReceiver(Context* context, const v1::TestReceiverRequest* request,
                        v1::TestReceiverResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto name, line_from(request->name(), kMostNameBytes, "name"));
      auto asking = notifications_.test(caller_of(*context), std::move(name));
      DRIFTWISE_CO_TRY(const auto said, co_await std::move(asking));
      response->set_answer(utf8_from(said));
      co_return Result<void>{};
    });
  }

 private:
  // Those that neither this database nor this cell knows.
  std::vector<std::string> unknown_channels(const SeriesAnswer& series) const {
    const auto known = overview_.status().values;
    std::vector<std::string> out;
    for (const auto& column : series.columns)
      if (!column.recorded && std::none_of(known.begin(), known.end(), [&](const auto& latest) {
            return latest.channel.name() == column.channel;
          }))
        out.push_back(column.channel);
    return out;
  }

  application::Host& host_;
  application::Overview& overview_;
  application::StoreReader& records_;
  application::Runs& runs_;
  application::Alarms& alarms_;
  application::Notifications& notifications_;
  boost::asio::thread_pool thread_{1};
  std::shared_ptr<WatchFeed> feed_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_watch_service(const application::Services& cell) {
  return std::make_unique<WatchService>(cell);
}

}  // namespace driftwise::rpc
