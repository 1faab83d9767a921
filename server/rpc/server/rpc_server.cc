#include "server/rpc/server/rpc_server.h"

#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>
#include <spdlog/spdlog.h>

#include <charconv>
#include <chrono>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/wire_time.h"

namespace driftwise::rpc {
namespace {

constexpr int kMostReceiveBytes = 33 * 1024 * 1024;
constexpr int kMostSendBytes = 64 * 1024 * 1024;
constexpr const char* kServiceNames[] = {"",
                                         "driftwise.v1.CellService",
                                         "driftwise.v1.RunService",
                                         "driftwise.v1.DataService",
                                         "driftwise.v1.ModelService",
                                         "driftwise.v1.TargetService",
                                         "driftwise.v1.TrajectoryService",
                                         "driftwise.v1.WatchService",
                                         "driftwise.v1.DiagnosisService",
                                         "driftwise.v1.ConfigurationService"};

struct Address {
  std::string host;
  int port = 0;
};

Result<Address> parse(const std::string& listen) {
  const auto colon = listen.rfind(':');
  Address out;
  if (colon != std::string::npos) {
    out.host = listen.substr(0, colon);
    const char* first = listen.data() + colon + 1;
    const char* last = listen.data() + listen.size();
    const auto [end, bad] = std::from_chars(first, last, out.port);
    if (bad == std::errc{} && end == last && out.port >= 0 && out.port <= 65535 &&
        !out.host.empty())
      return out;
  }
  return fail(ErrorCode::invalid_argument, reasons::kBadAddress,
              "listen: found '" + listen + "', expected host:port, for example 127.0.0.1:50051");
}

// What the libraries say about a client's bytes or a taken port is ours to say, in a sentence:
// theirs goes to the debug level of our log.
void take_over_logs() {
  static const bool done = [] {
    gpr_set_log_function([](gpr_log_func_args* args) { spdlog::debug("gRPC: {}", args->message); });
    google::protobuf::SetLogHandler(
        [](google::protobuf::LogLevel, const char*, int, const std::string& message) {
          spdlog::debug("protobuf: {}", message);
        });
    return true;
  }();
  static_cast<void>(done);
}

}  // namespace

Result<std::unique_ptr<RpcServer>> RpcServer::open(const application::Services& cell,
                                                   const std::string& listen,
                                                   std::vector<grpc::Service*> further) {
  DRIFTWISE_TRY(const auto address, parse(listen));
  DeviceDescription probe;  // the one rule of what loopback means
  probe.address = listen;
  if (!probe.on_loopback())
    return fail(
        ErrorCode::invalid_argument, reasons::kNotLoopback,
        "listen: " + listen +
            " can be reached from outside this computer; use 127.0.0.1 (and ssh -L from afar)");

  take_over_logs();
  std::unique_ptr<RpcServer> out(new RpcServer);
  out->services_.push_back(make_cell_service(cell));
  out->services_.push_back(make_run_service(cell));
  out->services_.push_back(make_data_service(cell));
  out->services_.push_back(make_model_service(cell));
  out->services_.push_back(make_diagnosis_service(cell));
  out->services_.push_back(make_target_service(cell));
  out->services_.push_back(make_standards_service(cell));
  out->services_.push_back(make_trajectory_service(cell));
  out->services_.push_back(make_watch_service(cell));
  out->services_.push_back(make_configuration_service(cell));

  grpc::EnableDefaultHealthCheckService(true);
  static const bool reflected = (grpc::reflection::InitProtoReflectionServerBuilderPlugin(), true);
  static_cast<void>(reflected);
  grpc::ServerBuilder builder;
  out->calls_ = std::make_shared<CallBook>();
  DRIFTWISE_TRY(auto gate, ConnectionGate::open(listen, out->calls_));
  out->gate_ = std::move(gate);
  auto acceptor = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
      grpc::InsecureServerCredentials());
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(entering(out->calls_));
  builder.experimental().SetInterceptorCreators(std::move(interceptors));
  grpc::ResourceQuota memory("doors");
  memory.Resize(kMostBufferBytes);
  builder.SetResourceQuota(memory);
  builder.SetMaxReceiveMessageSize(kMostReceiveBytes);
  builder.SetMaxSendMessageSize(kMostSendBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, 16 * 1024);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, 128);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 60'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 20'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  for (const auto& service : out->services_) builder.RegisterService(service.get());
  for (grpc::Service* service : further) builder.RegisterService(service);
  out->server_ = builder.BuildAndStart();
  if (!out->server_)
    return fail(ErrorCode::internal, reasons::kNoServer,
                "the gRPC library made no server: see its log");
  out->gate_->accept_for(std::move(acceptor));
  out->address_ = address.host + ":" + std::to_string(out->gate_->port());
  map_times_by(&cell.host);
  out->host_ = &cell.host;
  out->ready(false);
  return out;
}

RpcServer::~RpcServer() { shut_down(std::chrono::milliseconds(0)); }

void RpcServer::ready(bool is_ready) {
  auto* health = server_->GetHealthCheckService();
  for (const char* name : kServiceNames) health->SetServingStatus(name, is_ready);
}

void RpcServer::shut_down(std::chrono::milliseconds grace) {
  if (!server_) return;
  gate_.reset();
  server_->GetHealthCheckService()->Shutdown();
  calls_->end_streams();
  server_->Shutdown(std::chrono::system_clock::now() + grace);
  server_->Wait();
  server_.reset();
  stop_mapping_times_by(host_);
}

std::shared_ptr<grpc::Channel> RpcServer::in_process_channel() {
  return server_->InProcessChannel({});
}

}  // namespace driftwise::rpc
