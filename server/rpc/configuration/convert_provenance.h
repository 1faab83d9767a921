#pragma once
// Cell files, corrections and previews as messages.

#include "driftwise/v1/configuration_service.pb.h"
#include "driftwise/v1/diagnosis_service.pb.h"
#include "driftwise/v1/model_service.pb.h"
#include "driftwise/v1/run.pb.h"
#include "server/application/configuration/configurations.h"
#include "server/application/diagnoses/extensions.h"
#include "server/application/provenance/provenance.h"

namespace driftwise::rpc {

v1::ConfigurationChange change_from(const formats::ConfigurationChange& change);
v1::UsedConfiguration used_from(const UsedConfiguration& used);
v1::ConfigurationStart start_from(const ConfigurationStart& start);
v1::CorrectionMark mark_from(const CorrectionRecord& correction);
v1::PreviewExtensionResponse preview_from(const application::ExtensionPreview& preview);

// Marks of a run: its corrections, and with `whole` its cell files.
void add_ground(const application::RunGround& ground, bool whole, v1::Run& out);
// What the page to sign says of it: the cell file that it was measured under, never the present
// one.
void add_ground(const application::ModelGround& ground, v1::GetModelResponse& out);

}  // namespace driftwise::rpc
