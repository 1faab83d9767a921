#pragma once
// The services of driftwise.v1. Each borrows what it needs of the cell, which outlives the server.

#include <grpcpp/impl/service_type.h>

#include <memory>

#include "server/application/cell/services.h"

namespace driftwise::access {
class Authoriser;
class PageLinks;
class TokenBook;
}  // namespace driftwise::access

namespace driftwise::rpc {

std::unique_ptr<grpc::Service> make_cell_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_run_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_data_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_model_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_diagnosis_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_target_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_standards_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_trajectory_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_watch_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_configuration_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_queue_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_plan_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_record_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_commissioning_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_look_back_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_study_service(const application::Services& cell);
std::unique_ptr<grpc::Service> make_indentation_service(const application::Services& cell);
// tokens: nullptr: none are kept; links: nullptr: there is no page. All outlive the service.
std::unique_ptr<grpc::Service> make_access_service(access::Authoriser& authoriser,
                                                   access::TokenBook* tokens,
                                                   access::PageLinks* links);

}  // namespace driftwise::rpc
