#include "server/rpc/server/guard.h"

#include <google/protobuf/message.h>
#include <grpcpp/impl/rpc_service_method.h>

#include <list>
#include <mutex>
#include <unordered_set>
#include <utility>

#include "driftwise/v1/access.pb.h"
#include "server/access/bearer.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/call_context.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/error_mapping.h"
#include "server/rpc/shared/heard.h"
#include "server/rpc/shared/request_texts.h"

namespace driftwise::rpc {
namespace {

namespace gx = grpc::experimental;

std::string path_of(const google::protobuf::MethodDescriptor& method) {
  return "/" + method.service()->full_name() + "/" + method.name();
}

std::vector<std::string> properties(const grpc::AuthContext& context, const char* name) {
  std::vector<std::string> out;
  for (const auto& value : context.FindPropertyValues(name))
    out.emplace_back(value.data(), value.size());
  return out;
}

std::string bearer_of(const grpc::ServerContextBase& context) {
  const std::string_view header = metadata_value(context, "authorization");
  if (header.empty()) return {};
  // Another scheme is a try with something that is no token.
  const std::string_view token = access::bearer_in(header);
  return token.empty() ? "?" : std::string(token);
}

access::Evidence evidence_of(const grpc::ServerContextBase& context) {
  access::Evidence evidence;
  evidence.from = peer_of(context);
  evidence.stated_name = stated_name(context);
  evidence.bearer = bearer_of(context);
  const std::string peer = context.peer();
  if (peer.starts_with("unix")) {
    evidence.door = access::Door::unix_socket;
    return evidence;
  }
  // First what the connection is: a peer without a name is no reason to believe anything.
  evidence.door = access::Door::loopback;
  const auto connection = context.auth_context();
  if (!connection) return evidence;
  for (const auto& type : properties(*connection, "transport_security_type"))
    if (type == "ssl" || type == "tls") evidence.door = access::Door::tls;
  if (evidence.door != access::Door::tls) return evidence;
  evidence.certificate_uris = properties(*connection, "peer_uri");
  if (auto names = properties(*connection, "x509_common_name"); !names.empty())
    evidence.certificate_name = std::move(names.front());
  if (auto whole = properties(*connection, "x509_pem_cert"); !whole.empty())
    evidence.certificate_pem = std::move(whole.front());
  return evidence;
}

Result<access::Identity> identity_behind(const grpc::ServerContextBase& context,
                                         access::Authoriser& authoriser) {
  if (from_inside(context))
    if (auto who = authoriser.vouched(metadata_value(context, access::Authoriser::kVouchedKey)))
      return *who;
  return authoriser.identify(evidence_of(context));
}

// Lives as long as the call, and has the end of a refused one say why.
class Refusing final : public gx::Interceptor {
 public:
  explicit Refusing(const CallContext& context) : context_(context) {}
  void Intercept(gx::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(gx::InterceptionHookPoints::PRE_SEND_STATUS) &&
        context_.refused())
      methods->ModifySendStatus(*context_.refusal());
    methods->Proceed();
  }

 private:
  const CallContext& context_;  // gRPC keeps it until the call's interceptors are gone
};

Result<void> check_heard(std::string_view path, const grpc::ServerContextBase& context) {
  const auto heard_ms = metadata_value(context, kHeardKey);
  if (heard_ms.empty()) return {};
  return heard_recently(path, heard_ms, std::chrono::system_clock::now());
}

class JudgingFactory final : public gx::ServerInterceptorFactoryInterface {
 public:
  JudgingFactory(access::Authoriser& authoriser, RoleTable table)
      : authoriser_(authoriser), table_(std::move(table)) {}

  gx::Interceptor* CreateServerInterceptor(gx::ServerRpcInfo* info) override {
    auto* context = dynamic_cast<CallContext*>(info->server_context());
    if (context == nullptr || info->method() == nullptr) return nullptr;
    const auto needed = table_.find(std::string_view(info->method()));
    if (needed == table_.end()) return nullptr;
    auto who = identity_behind(*context, authoriser_);
    if (!who) return refuse(*context, who.error());
    std::string_view name = needed->first;
    name.remove_prefix(name.rfind('/') + 1);
    if (const auto may = authoriser_.authorise(*who, {name, needed->second}); !may)
      return refuse(*context, may.error());
    if (const auto recent = check_heard(info->method(), *context); !recent)
      return refuse(*context, recent.error());
    context->allow(std::move(*who));
    return info->method() == kComputeTarget ? nullptr : new Refusing(*context);
  }

 private:
  static gx::Interceptor* refuse(CallContext& context, const Error& why) {
    context.refuse(to_status(why));
    return new Refusing(context);
  }

  access::Authoriser& authoriser_;
  RoleTable table_;
};

// gRPC gives back those of calls that began; the others (at the end of the server) go here.
class JudgedContexts final : public grpc::ContextAllocator {
 public:
  ~JudgedContexts() override {
    for (auto* context : out_) delete context;
  }
  grpc::CallbackServerContext* NewCallbackServerContext() override {
    auto* context = new CallContext;
    const std::lock_guard lock(mutex_);
    out_.insert(context);
    return context;
  }
  void Release(grpc::CallbackServerContext* context) override {
    {
      const std::lock_guard lock(mutex_);
      // Of a call to a method that nobody has, gRPC gives back a context of its own, which it
      // destroys itself.
      if (out_.erase(context) == 0) return;
    }
    delete context;
  }

 private:
  std::mutex mutex_;
  std::unordered_set<grpc::CallbackServerContext*> out_;
};

// A generated handler runs no method of a call whose message was not good; a refused call is one.
class GuardedHandler final : public grpc::internal::MethodHandler {
 public:
  GuardedHandler(grpc::internal::MethodHandler& inner, bool checks_texts)
      : inner_(inner), checks_texts_(checks_texts) {}

  void RunHandler(const HandlerParameter& parameter) override {
    auto* context = dynamic_cast<CallContext*>(parameter.server_context);
    const auto is_allowed = [context] {
      return context != nullptr && context->who() && !context->refused();
    };
    if (is_allowed() && checks_texts_ && parameter.request != nullptr) {
      // Generated messages have Message as their one base: the pointer is the same.
      const auto* request = static_cast<const google::protobuf::Message*>(parameter.request);
      if (const auto good = check_texts(*request); !good) context->refuse(to_status(good.error()));
    }
    if (is_allowed()) return inner_.RunHandler(parameter);
    inner_.RunHandler({parameter.call, parameter.server_context, parameter.request,
                       grpc::Status(grpc::StatusCode::PERMISSION_DENIED, ""),
                       parameter.internal_data, parameter.call_requester});
  }
  void* Deserialize(grpc_call* call, grpc_byte_buffer* request, grpc::Status* status,
                    void** handler_data) override {
    return inner_.Deserialize(call, request, status, handler_data);
  }

 private:
  grpc::internal::MethodHandler& inner_;
  bool checks_texts_;
};

class GuardedService final : public grpc::Service {
 public:
  GuardedService(grpc::Service& inner, const google::protobuf::ServiceDescriptor& descriptor) {
    using grpc::internal::RpcMethod;
    for (int i = 0; i < descriptor.method_count(); ++i) {
      const auto& method = *descriptor.method(i);
      const auto type =
          method.server_streaming() ? RpcMethod::SERVER_STREAMING : RpcMethod::NORMAL_RPC;
      names_.push_back(path_of(method));
      AddMethod(new grpc::internal::RpcServiceMethod(names_.back().c_str(), type, nullptr));
      MarkMethodCallback(i, new GuardedHandler(*(inner.*&GuardedService::GetHandler)(i),
                                               names_.back() != kComputeTarget));
    }
  }

 private:
  std::list<std::string> names_;  // gRPC keeps pointers to them
};

}  // namespace

Result<void> add_roles(const google::protobuf::ServiceDescriptor& service, RoleTable& table) {
  for (int i = 0; i < service.method_count(); ++i) {
    const auto& method = *service.method(i);
    const auto role = method.options().GetExtension(v1::role);
    if (role < v1::ROLE_VIEWER || role > v1::ROLE_ADMIN)
      return fail(ErrorCode::internal, reasons::kNoRole,
                  method.full_name() +
                      " declares no role: give it option (driftwise.v1.role) in its proto file");
    table.insert_or_assign(path_of(method), static_cast<access::Role>(role));
  }
  return {};
}

std::unique_ptr<gx::ServerInterceptorFactoryInterface> judging(access::Authoriser& authoriser,
                                                               RoleTable table) {
  return std::make_unique<JudgingFactory>(authoriser, std::move(table));
}

std::unique_ptr<grpc::ContextAllocator> judged_contexts() {
  return std::make_unique<JudgedContexts>();
}

std::unique_ptr<grpc::Service> guarded(grpc::Service& inner,
                                       const google::protobuf::ServiceDescriptor& descriptor) {
  return std::make_unique<GuardedService>(inner, descriptor);
}

}  // namespace driftwise::rpc
