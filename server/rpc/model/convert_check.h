#pragma once
// A check of a model, and what offers would add: domain -> proto.

#include "driftwise/v1/model_service.pb.h"
#include "server/application/checks/model_checks.h"
#include "server/calibration/offer.h"

namespace driftwise::rpc {

v1::CheckModelResponse check_from(const application::ModelCheck& check);
v1::OfferOutcome offer_from(const calibration::OfferResult& offer);

}  // namespace driftwise::rpc
