#include "tests/faults/acknowledged_points.h"

#include <google/protobuf/text_format.h>
#include <grpcpp/channel.h>

#include <stdexcept>

#include "driftwise/v1/run_service.grpc.pb.h"

namespace driftwise::tests {
namespace {

std::string text_of(const v1::Point& point) {
  google::protobuf::TextFormat::Printer printer;
  std::string text;
  printer.PrintToString(point, &text);
  return text;
}

}  // namespace

PointWatcher::PointWatcher(std::shared_ptr<grpc::Channel> channel, std::int64_t run_id)
    : channel_(std::move(channel)), run_id_(run_id), thread_([this] { watch(); }) {}

PointWatcher::~PointWatcher() { join(); }

void PointWatcher::join() {
  if (thread_.joinable()) thread_.join();
}

void PointWatcher::watch() {
  grpc::ClientContext context;
  v1::WatchRunRequest request;
  request.set_run_id(run_id_);
  const auto reader = v1::RunService::NewStub(channel_)->WatchRun(&context, request);
  v1::WatchRunResponse response;
  while (reader->Read(&response)) {
    const auto accepted = response.progress().run().accepted_count();
    if (accepted > acknowledged_) {
      acknowledged_ = accepted;
      fetch();
    }
  }
  reader->Finish();
}

void PointWatcher::fetch() {
  grpc::ClientContext context;
  v1::ListPointsRequest request;
  request.set_run_id(run_id_);
  request.set_after_point_id(last_point_id_);
  request.set_limit(10000);
  v1::ListPointsResponse response;
  if (!v1::RunService::NewStub(channel_)->ListPoints(&context, request, &response).ok()) return;
  for (const auto& point : response.points()) {
    last_point_id_ = point.id();
    if (!point.passage()) seen_[point.row()] = {point.id(), point.row(), text_of(point)};
  }
}

PointsByRow points_by_row(const std::shared_ptr<grpc::Channel>& channel, std::int64_t run_id) {
  PointsByRow points;
  grpc::ClientContext context;
  v1::ListPointsRequest request;
  request.set_run_id(run_id);
  request.set_limit(10000);
  v1::ListPointsResponse response;
  const auto status = v1::RunService::NewStub(channel)->ListPoints(&context, request, &response);
  if (!status.ok()) throw std::runtime_error("ListPoints: " + status.error_message());
  for (const auto& point : response.points())
    if (!point.passage() &&
        !points.emplace(point.row(), SeenPoint{point.id(), point.row(), text_of(point)}).second)
      throw std::runtime_error("row " + std::to_string(point.row()) + " is there twice");
  return points;
}

}  // namespace driftwise::tests
