#pragma once
// The services of driftwise.v1 over one cell. Each borrows the cell, which outlives the
// server.

#include <grpcpp/impl/service_type.h>

#include <memory>

#include "server/application/ports/cell.h"

namespace driftwise::rpc {

std::unique_ptr<grpc::Service> make_cell_service(application::Cell& cell);
std::unique_ptr<grpc::Service> make_run_service(application::Cell& cell);
std::unique_ptr<grpc::Service> make_data_service(application::Cell& cell);
std::unique_ptr<grpc::Service> make_model_service(application::Cell& cell);
std::unique_ptr<grpc::Service> make_diagnosis_service(application::Cell& cell);
std::unique_ptr<grpc::Service> make_target_service(application::Cell& cell);
std::unique_ptr<grpc::Service> make_standards_service(application::Cell& cell);
std::unique_ptr<grpc::Service> make_trajectory_service(application::Cell& cell);
std::unique_ptr<grpc::Service> make_watch_service(application::Cell& cell);
std::unique_ptr<grpc::Service> make_configuration_service(application::Cell& cell);

}  // namespace driftwise::rpc
