#include "server/rpc/server/rpc_server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>
#include <grpcpp/support/channel_arguments.h>
#include <spdlog/spdlog.h>

#include <charconv>
#include <chrono>

#include "server/core/devices/device_description.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/server/guard.h"
#include "server/rpc/server/library_logs.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/wire_time.h"

namespace driftwise::rpc {
namespace {

constexpr int kMostReceiveBytes = 33 * 1024 * 1024;
constexpr int kMostSendBytes = 64 * 1024 * 1024;
constexpr int kHandshake_ms = 10'000;  // then a client that has not finished TLS is gone

struct MadeService {
  const char* name;
  std::unique_ptr<grpc::Service> (*make)(const application::Services& cell);
};
constexpr MadeService kServices[] = {
    {"driftwise.v1.CellService", make_cell_service},
    {"driftwise.v1.RunService", make_run_service},
    {"driftwise.v1.DataService", make_data_service},
    {"driftwise.v1.ModelService", make_model_service},
    {"driftwise.v1.TargetService", make_target_service},
    {"driftwise.v1.TrajectoryService", make_trajectory_service},
    {"driftwise.v1.WatchService", make_watch_service},
    {"driftwise.v1.DiagnosisService", make_diagnosis_service},
    {"driftwise.v1.StandardsService", make_standards_service},
    {"driftwise.v1.ConfigurationService", make_configuration_service},
    {"driftwise.v1.QueueService", make_queue_service},
    {"driftwise.v1.PlanService", make_plan_service},
    {"driftwise.v1.RecordService", make_record_service},
    {"driftwise.v1.CommissioningService", make_commissioning_service},
    {"driftwise.v1.LookBackService", make_look_back_service},
    {"driftwise.v1.StudyService", make_study_service},
    {"driftwise.v1.IndentationService", make_indentation_service}};
constexpr const char* kAccessService = "driftwise.v1.AccessService";

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

// The library reads the files again when they change. A client may come without a certificate: its
// token is looked at then. One that has a certificate of somebody else comes nowhere.
std::shared_ptr<grpc::ServerCredentials> tls_credentials(const AccessDescription& access) {
  namespace gx = grpc::experimental;
  gx::TlsServerCredentialsOptions options(std::make_shared<gx::FileWatcherCertificateProvider>(
      access.key, access.certificate, access.authority, RpcServer::kReload_s));
  options.watch_identity_key_cert_pairs();
  if (!access.authority.empty()) {
    options.watch_root_certs();
    options.set_cert_request_type(GRPC_SSL_REQUEST_CLIENT_CERTIFICATE_AND_VERIFY);
  }
  return gx::TlsServerCredentials(options);
}

}  // namespace

struct RpcServer::Building {
  grpc::ServerBuilder builder;
  access::Authoriser& authoriser;
  access::TokenBook* tokens = nullptr;
  access::PageLinks* links = nullptr;
  std::vector<std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor>> acceptors = {};
  RoleTable roles = {};
};

Result<void> RpcServer::add_services(const application::Services& cell, Building& building) {
  const auto add = [&](const char* name, std::unique_ptr<grpc::Service> service) -> Result<void> {
    const auto* descriptor =
        google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(name);
    if (descriptor == nullptr)
      return fail(ErrorCode::internal, reasons::kNoServer,
                  std::string("the service ") + name + " has no descriptor");
    DRIFTWISE_RETURN_IF_ERROR(add_roles(*descriptor, building.roles));
    services_.push_back(std::move(service));
    guarded_.push_back(guarded(*services_.back(), *descriptor));
    building.builder.RegisterService(guarded_.back().get());
    return {};
  };
  for (const auto& one : kServices) DRIFTWISE_RETURN_IF_ERROR(add(one.name, one.make(cell)));
  return add(kAccessService,
             make_access_service(building.authoriser, building.tokens, building.links));
}

Result<void> RpcServer::add_door(Building& building, const std::string& address,
                                 std::shared_ptr<grpc::ServerCredentials> credentials) {
  DRIFTWISE_TRY(auto gate, ConnectionGate::open(address, calls_));
  gates_.push_back(std::move(gate));
  building.acceptors.push_back(building.builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
      std::move(credentials)));
  return {};
}

Result<void> RpcServer::add_doors(Building& building, const std::string& listen,
                                  access::Access* access) {
  DRIFTWISE_TRY(const auto address, parse(listen));
  DeviceDescription probe;  // the one rule of what loopback means
  probe.address = listen;
  if (!probe.on_loopback())
    return fail(ErrorCode::invalid_argument, reasons::kNotLoopback,
                "listen: " + listen +
                    " can be reached from outside this computer without TLS; use 127.0.0.1 here, "
                    "and [access] listen with a certificate for others");
  DRIFTWISE_RETURN_IF_ERROR(add_door(building, listen, grpc::InsecureServerCredentials()));
  address_ = address.host + ":" + std::to_string(gates_.back()->port());
  if (access == nullptr) return {};
  const auto made =
      add_door(building, "unix:" + access->socket_path(), grpc::InsecureServerCredentials());
  if (made)
    socket_path_ = access->socket_path();
  else
    spdlog::warn("no local socket: {}", made.error().message);
  const auto& outside = access->description();
  if (outside.listen.empty()) return {};
  DRIFTWISE_TRY(const auto tls, parse(outside.listen));
  DRIFTWISE_RETURN_IF_ERROR(add_door(building, outside.listen, tls_credentials(outside)));
  tls_address_ = tls.host + ":" + std::to_string(gates_.back()->port());
  return {};
}

Result<std::unique_ptr<RpcServer>> RpcServer::open(const application::Services& cell,
                                                   const std::string& listen,
                                                   std::vector<grpc::Service*> further,
                                                   access::Access* access) {
  take_over_library_logs();
  std::unique_ptr<RpcServer> out(new RpcServer);
  out->calls_ = std::make_shared<CallBook>();
  if (access == nullptr)
    out->own_authoriser_ = std::make_unique<access::Authoriser>(access::Authoriser::Parts{});
  Building building{.builder = {},
                    .authoriser = access ? access->authoriser() : *out->own_authoriser_,
                    .tokens = access ? &access->tokens() : nullptr,
                    .links = access ? &access->links() : nullptr};
  auto& builder = building.builder;
  DRIFTWISE_RETURN_IF_ERROR(out->add_doors(building, listen, access));

  grpc::EnableDefaultHealthCheckService(true);
  static const bool reflected = (grpc::reflection::InitProtoReflectionServerBuilderPlugin(), true);
  static_cast<void>(reflected);
  DRIFTWISE_RETURN_IF_ERROR(out->add_services(cell, building));
  for (grpc::Service* service : further) builder.RegisterService(service);
  builder.SetContextAllocator(judged_contexts());
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(entering(out->calls_));
  interceptors.push_back(judging(building.authoriser, std::move(building.roles)));
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
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshake_ms);
  out->server_ = builder.BuildAndStart();
  if (!out->server_)
    return fail(ErrorCode::internal, reasons::kNoServer,
                "the gRPC library made no server: see its log");
  for (std::size_t i = 0; i < out->gates_.size(); ++i) {
    const bool is_tls = !out->tls_address_.empty() && i + 1 == out->gates_.size();  // opened last
    out->gates_[i]->accept_for(std::move(building.acceptors[i]),
                               is_tls ? &note_tls_client : nullptr);
  }
  map_times_by(&cell.host);
  out->host_ = &cell.host;
  out->ready(false);
  return out;
}

RpcServer::~RpcServer() {
  if (!shut_down(std::chrono::milliseconds(0))) closing_.join();
}

void RpcServer::ready(bool is_ready) {
  auto* health = server_->GetHealthCheckService();
  health->SetServingStatus("", is_ready);
  for (const auto& one : kServices) health->SetServingStatus(one.name, is_ready);
  health->SetServingStatus(kAccessService, is_ready);
}

bool RpcServer::shut_down(std::chrono::milliseconds grace) {
  constexpr std::chrono::seconds kAfterGrace{1};  // for the answers to the cancelled calls
  if (!server_) return true;
  if (!closing_.joinable()) {
    gates_.clear();
    server_->GetHealthCheckService()->Shutdown();
    calls_->end_streams();
    std::promise<void> closed;
    closed_ = closed.get_future();
    closing_ = std::thread([server = server_.get(), grace, closed = std::move(closed)]() mutable {
      server->Shutdown(std::chrono::system_clock::now() + grace);
      server->Wait();
      closed.set_value();
    });
  }
  if (closed_.wait_for(grace + kAfterGrace) != std::future_status::ready) return false;
  closing_.join();
  server_.reset();
  stop_mapping_times_by(host_);
  return true;
}

std::shared_ptr<grpc::Channel> RpcServer::in_process_channel() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMostSendBytes);  // the library's own limit is 4 MiB
  return server_->InProcessChannel(arguments);
}

}  // namespace driftwise::rpc
