#pragma once
// Commissioning: domain -> proto.

#include "driftwise/v1/commissioning_service.pb.h"
#include "server/application/commissioning/commissioning.h"
#include "server/application/manual/jogs.h"
#include "server/core/description/cell_description.h"

namespace driftwise::rpc {

v1::CheckCellResponse check_from(const application::CellCheck& check);
v1::Jog jog_from(const application::JogState& jog, const CellDescription& cell);
v1::CompareThermometersResponse thermometers_from(const application::ThermometerReport& report,
                                                  const CellDescription& cell);
v1::Rest rest_from(const application::RestReport& report);
v1::Certificate certificate_from(const application::CertificateState& state);

}  // namespace driftwise::rpc
