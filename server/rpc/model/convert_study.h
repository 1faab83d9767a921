#pragma once
// Comparisons of methods and studies of sensors: requests -> domain with their checks, domain ->
// proto.

#include "driftwise/v1/model_service.pb.h"
#include "server/application/analyses/studies.h"

namespace driftwise::rpc {

// Errors: those of fit_request_from, but the formula may be empty; BAD_METHOD, BAD_OPTION
// (fold_count), TOO_LONG.
Result<application::MethodsRequest> methods_request_from(const v1::CompareMethodsRequest& request);
// Errors: those of fit_request_from; BAD_OPTION (tolerance).
Result<application::SensorsRequest> sensors_request_from(const v1::StudySensorsRequest& request);

v1::CompareMethodsResponse comparison_from(const std::vector<identification::Judgement>& judgements,
                                           const std::string& formula);
v1::StudySensorsResponse sensor_choice_from(const application::SensorChoice& choice);

}  // namespace driftwise::rpc
