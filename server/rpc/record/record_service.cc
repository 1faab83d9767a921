#include "driftwise/v1/record_service.grpc.pb.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/upkeep/record_keeping.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"
#include "server/rpc/shared/watch_sources.h"
#include "server/rpc/shared/wire_time.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

v1::Act act_from(const AuditRecord& act) {
  v1::Act out;
  out.set_id(act.id);
  *out.mutable_time() = timestamp_from(act.at.utc);
  out.set_who(utf8_from(act.by.name));
  out.set_proof(utf8_from(act.by.proof));
  out.set_from(utf8_from(act.by.from));
  out.set_what(utf8_from(act.what));
  out.set_subject(utf8_from(act.subject));
  out.set_before(utf8_from(act.before));
  out.set_after(utf8_from(act.after));
  out.set_outcome(utf8_from(act.outcome));
  out.set_event_id(act.event.value);
  return out;
}

v1::ChainHead head_from(const ChainHead& head) {
  v1::ChainHead out;
  out.set_entry(head.entry);
  out.set_hash(head.hash);
  return out;
}

Result<std::optional<ChainHead>> kept_from(const v1::VerifyRecordRequest& request) {
  if (!request.has_kept()) return std::optional<ChainHead>();
  const auto& kept = request.kept();
  const auto head = kept.hash().size() == 64
                        ? chain_head_from(kept.hash() + "@" + std::to_string(kept.entry()))
                        : std::nullopt;
  if (!head)
    return fail(ErrorCode::invalid_argument, reasons::kBadChainHead,
                "kept: expected a hash of 64 lower-case hexadecimal digits and an entry from 1 on, "
                "as GetChainHead answered");
  return head;
}

Result<ThinningOrder> thinning_from(const v1::ThinReadingsRequest& request) {
  constexpr std::int64_t kMostSeconds = 9'000'000'000;  // 64 bits of nanoseconds reach 2262
  const auto& before = request.before_time();
  if (!request.has_before_time() || before.seconds() < 0 || before.seconds() > kMostSeconds ||
      before.nanos() < 0 || before.nanos() > 999'999'999)
    return fail(ErrorCode::invalid_argument, reasons::kBadTime,
                "before_time: expected an instant between 1970 and 2255");
  ThinningOrder order;
  order.before = cell_time_from(UtcTime{before.seconds() * 1'000'000'000 + before.nanos()});
  DRIFTWISE_TRY(const auto every, nanoseconds_from(request.every_duration(), "every_duration"));
  order.every_ns = every.count();
  order.reducer = request.reducer();
  return order;
}

class RecordService final : public v1::RecordService::CallbackService {
 public:
  explicit RecordService(const application::Services& cell)
      : host_(cell.host),
        records_(cell.records),
        keeping_(cell.keeping),
        bundles_(cell.support),
        reports_(cell.reports),
        texts_(WholeTexts::make(cell.host.executor())) {}

  Reactor* ListActs(Context* context, const v1::ListActsRequest* request,
                    v1::ListActsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_RETURN_IF_ERROR(check_cursor(request->before_id(), "before_id"));
      DRIFTWISE_CO_TRY(const auto limit, limit_from(request->limit(), 100, 1000));
      auto reading = records_.audit().acts(request->before_id(), limit);
      DRIFTWISE_CO_TRY(const auto acts, co_await std::move(reading));
      for (const auto& act : acts) *response->add_acts() = act_from(act);
      co_return Result<void>{};
    });
  }

  Reactor* GetChainHead(Context* context, const v1::GetChainHeadRequest*,
                        v1::GetChainHeadResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      auto reading = records_.audit().head();
      DRIFTWISE_CO_TRY(const auto head, co_await std::move(reading));
      *response->mutable_head() = head_from(head);
      co_return Result<void>{};
    });
  }

  Reactor* BackUpRecord(Context* context, const v1::BackUpRecordRequest*,
                        v1::BackUpRecordResponse* response) override {
    return answer(host_, context, [this, context, response]() -> Awaitable<Result<void>> {
      auto copying = keeping_.back_up(caller_of(*context));
      DRIFTWISE_CO_TRY(const auto copy, co_await std::move(copying));
      v1::RecordCopy& out = *response->mutable_copy();
      out.set_path(utf8_from(copy.path));
      out.set_byte_count(copy.bytes);
      out.set_row_count(copy.rows);
      *out.mutable_head() = head_from(copy.head);
      co_return Result<void>{};
    });
  }

  Reactor* VerifyRecord(Context* context, const v1::VerifyRecordRequest* request,
                        v1::VerifyRecordResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto kept, kept_from(*request));
      auto checking = keeping_.verify(kept);
      DRIFTWISE_CO_TRY(const auto report, co_await std::move(checking));
      *response->mutable_head() = head_from(report.head);
      response->set_unit_count(report.units);
      response->set_row_count(report.rows);
      response->set_difference_count(report.differences);
      response->set_thinned_reading_count(report.thinned_readings);
      for (const auto& sentence : report.thinned) response->add_thinned(utf8_from(sentence));
      for (const auto& sentence : report.first) response->add_differences(utf8_from(sentence));
      co_return Result<void>{};
    });
  }

  Reactor* ThinReadings(Context* context, const v1::ThinReadingsRequest* request,
                        v1::ThinReadingsResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto order, thinning_from(*request));
      auto thinning = keeping_.thin(order, caller_of(*context));
      DRIFTWISE_CO_TRY(const auto done, co_await std::move(thinning));
      response->set_reading_count(done.readings);
      response->set_interval_count(done.intervals);
      co_return Result<void>{};
    });
  }

  grpc::ServerWriteReactor<v1::GetSupportBundleResponse>* GetSupportBundle(
      Context* context, const v1::GetSupportBundleRequest*) override {
    return Stream<v1::GetSupportBundleResponse>::open(
        host_.executor(), support_bundle(texts_, bundles_, caller_of(*context)));
  }

  grpc::ServerWriteReactor<v1::GetReportResponse>* GetReport(
      Context*, const v1::GetReportRequest* request) override {
    return Stream<v1::GetReportResponse>::open(host_.executor(),
                                               run_report(texts_, reports_, request->run_id()));
  }

 private:
  application::Host& host_;
  application::StoreReader& records_;
  application::RecordKeeping& keeping_;
  application::SupportBundles& bundles_;
  application::Reports& reports_;
  std::shared_ptr<WholeTexts> texts_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_record_service(const application::Services& cell) {
  return std::make_unique<RecordService>(cell);
}

}  // namespace driftwise::rpc
