#pragma once
// A robot's geometry as a stored model: `model import robot.toml`, `fit --run N --method
// kinematic`. docs/kinematics.md.

#include <CLI/App.hpp>

#include "clients/cli/core/session.h"
#include "driftwise/v1/model_service.pb.h"

namespace driftwise::cli {

// Asks the daemon, and prints the stored model.
ExitCode create_kinematic_model(const Session& session,
                                const v1::CreateKinematicModelRequest& request);

void add_import_command(CLI::App& model, Session& session);

}  // namespace driftwise::cli
