// Every request that is checked before the cell hears of it, from arbitrary bytes: refused with a
// reason, or taken.

#include <google/protobuf/stubs/logging.h>

#include <cstdlib>
#include <string>

#include "clients/cli/commands/trajectories/plan_block_text.h"
#include "clients/cli/core/assignment.h"
#include "clients/cli/core/console.h"
#include "driftwise/v1/error_detail.pb.h"
#include "server/application/queue/follow_up.h"
#include "server/application/queue/queue_condition.h"
#include "server/rpc/cell/motor_coordinates.h"
#include "server/rpc/data/convert_remarks.h"
#include "server/rpc/model/fit_request.h"
#include "server/rpc/queue/convert_queue.h"
#include "server/rpc/run/create_run_request.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/error_mapping.h"
#include "server/rpc/target/convert_target.h"

namespace {

using namespace driftwise;

template <class T>
void check(const Result<T>& result) {
  if (result) return;
  if (result.error().reason.empty() || result.error().message.empty()) std::abort();
  const auto back = rpc::to_error(rpc::to_status(result.error()));
  if (back.code != result.error().code || back.reason != result.error().reason) std::abort();
}

CellDescription one_axis() {
  DeviceDescription device;
  device.become<MotionSettings>().axes = {{{"q1", "mm"}, "X", -4.5, 4.5, 5}};
  CellDescription cell;
  cell.devices = {device};
  return cell;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const CellDescription cell = [] {
    google::protobuf::SetLogHandler(nullptr);  // it complains of every byte that is no text
    return one_axis();
  }();
  const std::string bytes(reinterpret_cast<const char*>(data), size);

  v1::CreateRunRequest create;
  if (create.ParseFromString(bytes)) check(rpc::create_run_from(create, RunRules{}));
  v1::AddQueueEntryRequest queued;
  if (queued.ParseFromString(bytes)) check(rpc::queue_draft_from(queued, RunRules{}));
  v1::ChangeQueueEntryRequest edit;
  if (edit.ParseFromString(bytes)) check(rpc::queue_edit_from(edit));
  check(application::parse_condition(bytes, {{"t12", "degC"}}));
  check(application::parse_follow_up(bytes));
  v1::CreateFitRequest fit;
  if (fit.ParseFromString(bytes)) check(rpc::fit_request_from(fit));
  v1::ExcludeRowsRequest exclude;
  if (exclude.ParseFromString(bytes)) check(rpc::exclusion_from(exclude));
  v1::NoteSubject subject;
  if (subject.ParseFromString(bytes)) check(rpc::subject_from(subject));
  v1::ComputeTargetRequest target;
  if (target.ParseFromString(bytes)) {
    check(rpc::pose_from(target.pose(), CellTime{}));
    check(rpc::motor_coordinates_from(target.pose(), cell));
  }
  check(cli::plan_block_from(bytes, {{"q1", "mm"}, {"q2", "mm"}}));
  check(cli::coordinates_from(bytes));
  v1::ErrorDetail detail;
  detail.set_message(rpc::utf8_from(bytes));
  if (!v1::ErrorDetail().ParseFromString(detail.SerializeAsString()))
    std::abort();  // rejects bytes that are no text
  static_cast<void>(rpc::to_error(grpc::Status(grpc::StatusCode::INTERNAL, "", bytes)));
  try {
    static_cast<void>(cli::assignment_from(bytes));
  } catch (const cli::Failure& failure) {
    if (failure.exit != cli::ExitCode::usage) std::abort();
  }
  return 0;
}
