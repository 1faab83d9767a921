#pragma once
// A robot's geometry as a stored model: `model import robot.toml`, `fit --run N --method
// kinematic`. docs/kinematics.md.

#include <CLI/App.hpp>

#include "clients/cli/core/connection.h"
#include "clients/cli/core/session.h"
#include "driftwise/v1/model_service.pb.h"

namespace driftwise::cli {

// Message of a fit's time-out: also says that the daemon continues. Other failures stay.
void explain_fit_timeout(Failure& failure);

// A call at whose end the daemon stores a model, minutes later: ask_for_fit(connection,
// &v1::ModelService::Stub::CreateFit, request).
template <class Method, class Request>
auto ask_for_fit(const Connection& connection, Method method, const Request& request) {
  constexpr double kFitTakes_s = 300;
  try {
    return connection.ask(method, request, kFitTakes_s);
  } catch (Failure& failure) {
    explain_fit_timeout(failure);
    throw;
  }
}

// Number of the model, or that its content was stored before: name and note of then stay.
void print_stored(const Console& console, const v1::Model& model, v1::CreateFitRequest asked);

// Asks the daemon, and prints the stored model.
ExitCode create_kinematic_model(const Session& session,
                                const v1::CreateKinematicModelRequest& request);

void add_import_command(CLI::App& model, Session& session);

}  // namespace driftwise::cli
