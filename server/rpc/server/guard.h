#pragma once
// The guard of the gRPC door: no call reaches a service before the authoriser has said that this
// caller may make it. The role that each rpc needs is its option in the proto.
//
// An interceptor judges a call when it begins, before its message is looked at, and sends the
// refusal. A service of ours is registered behind a service of the same methods (guarded()) which
// runs the method of a call that was allowed and of no other: a call that nobody has judged is
// refused too. So is a call that moves something and whose client has not heard the cell for too
// long (shared/heard.h). Texts that are too long (shared/request_texts.h) are refused there as
// well. Health and reflection answer everybody who reaches the door: they tell what the sources
// tell.
//
// Any thread. A call with a token that has not been seen since the start computes a scrypt
// (access/token_book.h).

#include <google/protobuf/descriptor.h>
#include <grpcpp/impl/service_type.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/server_interceptor.h>

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "server/access/authoriser.h"
#include "server/access/role.h"

namespace driftwise::rpc {

// A call without interceptors once it is allowed, and without a look at its texts: its time counts
// in microseconds, and of its request nothing but numbers is stored.
inline constexpr std::string_view kComputeTarget = "/driftwise.v1.TargetService/ComputeTarget";

// "/driftwise.v1.CellService/Home" -> the role it needs.
using RoleTable = std::map<std::string, access::Role, std::less<>>;

// Errors: internal NO_ROLE, naming an rpc without the option.
Result<void> add_roles(const google::protobuf::ServiceDescriptor& service, RoleTable& table);

// Judges the calls of the table's rpcs. authoriser: outlives the server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> judging(
    access::Authoriser& authoriser, RoleTable table);
// What judging() writes its verdict into: for ServerBuilder::SetContextAllocator.
std::unique_ptr<grpc::ContextAllocator> judged_contexts();

// The service behind the guard. inner: a callback service with the descriptor's methods, without
// streams from the client; it outlives the result.
std::unique_ptr<grpc::Service> guarded(grpc::Service& inner,
                                       const google::protobuf::ServiceDescriptor& descriptor);

}  // namespace driftwise::rpc
