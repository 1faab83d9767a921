#include "tests/support/running_cell.h"

#include <grpcpp/channel.h>
#include <grpcpp/create_channel.h>
#include <signal.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"

namespace driftwise::tests {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
constexpr auto kStartLimit = seconds(60);  // sanitizers on a busy machine

const std::string kBin = DRIFTWISE_BIN_DIR;
const std::string kSource = DRIFTWISE_SOURCE_DIR;

void set_operator(grpc::ClientContext& context) {
  context.AddMetadata("driftwise-operator", "test");
}

template <class Response>
Response must(const grpc::Status& status, Response response, const std::string& what) {
  if (!status.ok()) throw std::runtime_error(what + ": " + status.error_message());
  return response;
}

}  // namespace

RunningCell::RunningCell(CellOptions options) : options_(std::move(options)) {
  const std::string cell = kSource + "/deploy/cells/" + options_.cell;
  std::vector<std::string> arguments = {kBin + "/driftwise-cellsim",
                                        "--plant",
                                        cell + "/plant.toml",
                                        "--cell",
                                        options_.cell_file.empty()
                                            ? cell + "/cell.toml"
                                            : kSource + "/tests/data/cells/" + options_.cell_file,
                                        "--instantiate",
                                        folder(),
                                        "--speed",
                                        std::to_string(options_.speed),
                                        "--seed",
                                        std::to_string(options_.seed)};
  arguments.insert(arguments.end(), options_.cellsim_options.begin(),
                   options_.cellsim_options.end());
  cellsim_ = std::make_unique<Process>(arguments, options_.environment, folder() + "/cellsim.log");
  const auto line = cellsim_->read_line(kStartLimit);
  if (!line || !line->starts_with("READY "))
    throw std::runtime_error("driftwise-cellsim did not start: " +
                             read_file(folder() + "/cellsim.log"));
  ready_line_ = line->substr(6);
  // Nobody is there to say that the robot may move after a loss of power.
  edit_cell_file("after_power_loss = \"wait\"", "after_power_loss = \"go-on\"");
}

RunningCell::~RunningCell() {
  if (daemon_ && daemon_->running()) stop_daemon();
  if (cellsim_) {
    cellsim_->signal(SIGTERM);
    cellsim_->wait(seconds(5));
  }
}

void RunningCell::edit_cell_file(const std::string& found, const std::string& instead) const {
  const std::string path = folder() + "/cell.toml";
  std::string text = read_file(path);
  std::size_t at = text.find(found);
  if (at == std::string::npos) throw std::runtime_error(path + ": no '" + found + "'");
  for (; at != std::string::npos; at = text.find(found, at + instead.size()))
    text.replace(at, found.size(), instead);
  write_file(path, text);
}

void RunningCell::start_daemon(const std::vector<std::string>& environment) {
  auto both = options_.environment;
  both.insert(both.end(), environment.begin(), environment.end());
  const std::string notice = folder() + "/driftwised.json";
  std::filesystem::remove(notice);
  daemon_ = std::make_unique<Process>(
      std::vector<std::string>{kBin + "/driftwised", "--cell", folder() + "/cell.toml"}, both,
      folder() + "/driftwised.log");
  const auto until = std::chrono::steady_clock::now() + kStartLimit;
  while (!std::filesystem::exists(notice)) {
    if (!daemon_->running() || std::chrono::steady_clock::now() > until)
      throw std::runtime_error("driftwised did not start: " + daemon_log());
    std::this_thread::sleep_for(milliseconds(2));
  }
  const auto json = nlohmann::json::parse(read_file(notice));
  grpc_ = json.at("grpc");
  target_line_ = json.value("target_line", "");
  http_ = json.value("http", "");
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  channel_ = grpc::CreateCustomChannel(grpc_, grpc::InsecureChannelCredentials(), arguments);
}

void RunningCell::kill_daemon() {
  daemon_->signal(SIGKILL);
  daemon_->wait(seconds(10));
}

int RunningCell::stop_daemon() {
  channel_
      .reset();  // an idle channel of ours would not hear the daemon's goodbye, which waits for it
  daemon_->signal(SIGTERM);
  return daemon_->wait(seconds(20)).value_or(-1);
}

std::string RunningCell::database() const {
  for (const auto& entry : std::filesystem::directory_iterator(folder()))
    if (entry.path().extension() == ".sqlite") return entry.path().string();
  return {};
}

std::string RunningCell::device_address(const std::string& id) const {
  return nlohmann::json::parse(ready_line_).at(id).get<std::string>();
}

std::string RunningCell::daemon_log() const { return read_file(folder() + "/driftwised.log"); }

Finished RunningCell::cli(std::vector<std::string> arguments, milliseconds limit) const {
  arguments.insert(arguments.begin(), kBin + "/driftwise");
  return run_process(arguments, limit, {"DRIFTWISE_SERVER=" + grpc_, "NO_COLOR=1"});
}

Process RunningCell::cli_process(std::vector<std::string> arguments) const {
  arguments.insert(arguments.begin(), kBin + "/driftwise");
  return Process(arguments, {"DRIFTWISE_SERVER=" + grpc_, "NO_COLOR=1"}, folder() + "/cli.log");
}

std::string RunningCell::take_lease() {
  grpc::ClientContext context;
  set_operator(context);
  v1::TakeLeaseRequest request;
  request.mutable_lease_duration()->set_seconds(600);
  v1::TakeLeaseResponse response;
  const auto status = v1::CellService::NewStub(channel_)->TakeLease(&context, request, &response);
  return must(status, response, "TakeLease").lease().token();
}

v1::Run RunningCell::create_run(const std::string& trajectory_csv, const std::string& request_id) {
  v1::CreateRunRequest request;
  request.set_name("test");
  request.set_trajectory_name("test.csv");
  request.set_trajectory_text(trajectory_csv);
  request.set_request_id(request_id);
  request.set_lease_token(take_lease());
  grpc::ClientContext context;
  set_operator(context);
  v1::CreateRunResponse response;
  const auto status = v1::RunService::NewStub(channel_)->CreateRun(&context, request, &response);
  return must(status, response, "CreateRun").run();
}

v1::Run RunningCell::wait_until_over(std::int64_t run_id, milliseconds limit) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + limit);
  v1::WatchRunRequest request;
  request.set_run_id(run_id);
  const auto reader = v1::RunService::NewStub(channel_)->WatchRun(&context, request);
  v1::WatchRunResponse response;
  v1::Run run;
  while (reader->Read(&response)) run = response.progress().run();
  reader->Finish();
  return run;
}

}  // namespace driftwise::tests
