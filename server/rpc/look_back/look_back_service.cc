#include "driftwise/v1/look_back_service.grpc.pb.h"
#include "server/application/look_back/look_back.h"
#include "server/application/plumbing/store_reader.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
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

void add_series(const std::vector<application::ComparedSeries>& series,
                google::protobuf::RepeatedPtrField<v1::ComparedSeries>& out) {
  for (const auto& one : series) {
    auto& shown = *out.Add();
    shown.set_name(one.name);
    shown.set_unit(one.unit);
    for (const double hours : one.hours) shown.add_hours(static_cast<float>(hours));
    for (const double value : one.values) shown.add_values(value);
    shown.set_mean(one.mean);
    shown.set_range(one.range);
    if (one.rate_per_h) shown.set_rate_per_h(*one.rate_per_h);
  }
}

v1::TimeNote time_note_from(const TimeNoteRecord& note) {
  v1::TimeNote out;
  out.set_id(note.id);
  *out.mutable_note_time() = timestamp_from(note.about);
  *out.mutable_create_time() = timestamp_from(note.at.utc);
  out.set_who(utf8_from(note.who));
  out.set_text(utf8_from(note.text));
  out.set_channel(utf8_from(note.channel));
  return out;
}

void show_stability(const application::Stability& stability, v1::AnalyseStabilityResponse& out) {
  out.set_channel(utf8_from(stability.channel));
  out.set_unit(stability.unit);
  *out.mutable_from_time() = timestamp_from(stability.from);
  *out.mutable_to_time() = timestamp_from(stability.to);
  out.set_sample_count(stability.used);
  out.set_all_count(stability.all);
  out.set_interval_s(stability.interval_s);
  for (const auto& point : stability.allan) {
    auto& one = *out.add_allan();
    one.set_tau_s(point.tau_s);
    one.set_deviation(point.deviation);
    one.set_low(point.low);
    one.set_high(point.high);
    one.set_term_count(static_cast<std::int64_t>(point.terms));
  }
  for (const auto& point : stability.spectrum) {
    auto& one = *out.add_spectrum();
    one.set_frequency_hz(point.frequency_hz);
    one.set_density(point.density);
  }
  out.set_sentence(stability.sentence);
  if (!stability.allan.empty()) out.set_noise(stability.allan.front().deviation);
}

class LookBackService final : public v1::LookBackService::CallbackService {
 public:
  explicit LookBackService(const application::Services& cell)
      : host_(cell.host), records_(cell.records), look_back_(cell.look_back) {}

  Reactor* AnalyseStability(Context* context, const v1::AnalyseStabilityRequest* request,
                            v1::AnalyseStabilityResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_RETURN_IF_ERROR(check_size(request->channel(), kMostNameBytes, "channel"));
      DRIFTWISE_CO_TRY(const auto range, range_from(*request, host_));
      auto asking = look_back_.stability_of(request->channel(), range.from, range.to);
      DRIFTWISE_CO_TRY(const auto stability, co_await std::move(asking));
      show_stability(stability, *response);
      co_return Result<void>{};
    });
  }

  Reactor* CompareRuns(Context* context, const v1::CompareRunsRequest* request,
                       v1::CompareRunsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto runs, run_ids_from(request->run_ids()));
      std::optional<ModelId> model;
      if (request->has_model_id()) {
        DRIFTWISE_CO_RETURN_IF_ERROR(check_id(request->model_id(), "model_id"));
        model = ModelId{request->model_id()};
      }
      auto comparing = look_back_.compare(std::move(runs), model);
      DRIFTWISE_CO_TRY(const auto compared, co_await std::move(comparing));
      for (const auto& one : compared) {
        auto& out = *response->add_runs();
        out.set_run_id(one.run.id.value);
        out.set_name(utf8_from(one.run.name));
        const CellTime start = one.run.started.utc_ns != 0 ? one.run.started : one.run.created;
        *out.mutable_start_time() = timestamp_from(start);
        if (one.run.ended.utc_ns != 0)
          *out.mutable_run_duration() = duration_from(one.run.ended - start);
        out.set_point_count(one.run.accepted);
        add_series(one.zero, *out.mutable_zero());
        add_series(one.temperatures, *out.mutable_temperatures());
        add_series(one.residuals, *out.mutable_residuals());
        out.set_residual_trouble(utf8_from(one.residual_trouble));
      }
      co_return Result<void>{};
    });
  }

  Reactor* AddTimeNote(Context* context, const v1::AddTimeNoteRequest* request,
                       v1::AddTimeNoteResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      TimeNoteRecord note;
      DRIFTWISE_CO_TRY(note.text, line_from(request->text(), kMostNoteBytes, "text"));
      DRIFTWISE_CO_TRY(note.channel, line_from(request->channel(), kMostNameBytes, "channel"));
      DRIFTWISE_CO_RETURN_IF_ERROR(
          check_size(request->request_id(), kMostRequestIdBytes, "request_id"));
      note.request = request->request_id();
      note.about = host_.now();
      if (request->has_note_time()) {
        DRIFTWISE_CO_TRY(note.about, instant_from(request->note_time(), "note_time"));
      }
      auto adding = look_back_.add_note(caller_of(*context), std::move(note));
      DRIFTWISE_CO_TRY(const auto stored, co_await std::move(adding));
      *response->mutable_note() = time_note_from(stored);
      co_return Result<void>{};
    });
  }

  Reactor* ListTimeNotes(Context* context, const v1::ListTimeNotesRequest* request,
                         v1::ListTimeNotesResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto limit, limit_from(request->limit(), 100, 1000));
      CellTime from{0}, to{host_.now().utc_ns + 1};
      if (request->has_from_time()) {
        DRIFTWISE_CO_TRY(from, instant_from(request->from_time(), "from_time"));
      }
      if (request->has_to_time()) {
        DRIFTWISE_CO_TRY(to, instant_from(request->to_time(), "to_time"));
      }
      auto reading = records_.remarks().time_notes(from, to, limit);
      DRIFTWISE_CO_TRY(const auto notes, co_await std::move(reading));
      for (const auto& note : notes) *response->add_notes() = time_note_from(note);
      co_return Result<void>{};
    });
  }

 private:
  application::Host& host_;
  application::StoreReader& records_;
  application::LookBack& look_back_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_look_back_service(const application::Services& cell) {
  return std::make_unique<LookBackService>(cell);
}

}  // namespace driftwise::rpc
