#include <fstream>
#include <nlohmann/json.hpp>

#include "clients/cpp/convert.h"
#include "clients/cpp/follower_state.h"
#include "clients/cpp/link.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/target_service.grpc.pb.h"

namespace driftwise::client {

struct Client::State {
  std::shared_ptr<Link> link;
  std::unique_ptr<v1::TargetService::Stub> targets;
  std::unique_ptr<v1::CellService::Stub> cell;
};

Client::Client(std::string address, std::string operator_name, const Credentials& credentials)
    : state_(new State) {
  state_->link = std::make_shared<Link>(std::move(address), std::move(operator_name), credentials);
  state_->targets = v1::TargetService::NewStub(state_->link->channel);
  state_->cell = v1::CellService::NewStub(state_->link->channel);
}
Client::~Client() = default;
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;

Answer<Target> Client::target(const Pose& pose, std::chrono::milliseconds limit) const {
  if (state_->link->trouble) return tl::unexpected(*state_->link->trouble);
  grpc::ClientContext context;
  state_->link->sign(context);
  context.set_deadline(std::chrono::system_clock::now() + limit);
  v1::ComputeTargetRequest request;
  put_pose(pose, request);
  v1::ComputeTargetResponse response;
  const grpc::Status status = state_->targets->ComputeTarget(&context, request, &response);
  if (!status.ok()) return tl::unexpected(state_->link->failure_of(status));
  return target_from(response.target());
}

TargetFollower Client::follow(Pose pose, std::chrono::milliseconds min_interval) const {
  return TargetFollower(
      std::make_unique<TargetFollower::State>(state_->link, std::move(pose), min_interval));
}

namespace {

// Whatever the reason: who asked for a stop must know that none was made.
tl::unexpected<Failure> not_stopped(Failure failure) {
  failure.message = "NOT STOPPED: use the emergency switch: " + failure.message;
  return tl::unexpected<Failure>(std::move(failure));
}

}  // namespace

Answer<void> Client::stop_all(std::chrono::milliseconds limit) const {
  if (state_->link->trouble) return not_stopped(*state_->link->trouble);
  grpc::ClientContext context;
  state_->link->sign(context);
  context.set_deadline(std::chrono::system_clock::now() + limit);
  v1::StopAllResponse response;
  const grpc::Status status = state_->cell->StopAll(&context, {}, &response);
  if (!status.ok()) return not_stopped(state_->link->failure_of(status));
  if (!response.confirmed())
    return tl::unexpected(Failure{"STOP_NOT_CONFIRMED", response.message()});
  return {};
}

Answer<std::string> address_in(const std::filesystem::path& driftwised_json) {
  std::ifstream file(driftwised_json);
  if (!file)
    return tl::unexpected(Failure{
        "NO_NOTICE", driftwised_json.string() +
                         ": cannot be read; the daemon writes it beside its cell file when it is "
                         "ready, and removes it when it ends"});
  const auto json = nlohmann::json::parse(file, nullptr, false);
  if (!json.is_object() || !json.contains("grpc") || !json["grpc"].is_string())
    return tl::unexpected(Failure{
        "BAD_NOTICE", driftwised_json.string() +
                          ": expected a JSON object with the daemon's address under \"grpc\""});
  return json["grpc"].get<std::string>();
}

}  // namespace driftwise::client
