#pragma once
// A run as the page of a report reads it: driftwise.run-report.v1, docs/web-report.md. Pure.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "driftwise/v1/cell_service.pb.h"
#include "driftwise/v1/commissioning_service.pb.h"
#include "driftwise/v1/record_service.pb.h"
#include "driftwise/v1/run_service.pb.h"

namespace driftwise::cli {

struct ReportSource {
  v1::GetStatusResponse cell;
  v1::GetRunResponse run;
  std::vector<v1::Point> points;  // oldest first
  std::vector<v1::Attempt> attempts;
  std::vector<v1::Closure> closures;
  std::vector<v1::Event> events;  // of this run
  // What compensation achieved; nothing: a run without wanted poses.
  std::optional<v1::VerifyRunsResponse> verification;
  v1::ListCertificatesResponse certificates;
  v1::ChainHead head;  // of the record; entry 0: it has none
  std::string made;    // ISO 8601 UTC
  std::string version;
};

nlohmann::ordered_json report_json(const ReportSource& source);

// Little-endian float32, as base64: what the page calls packed.
std::string packed(const std::vector<double>& values);

// The template with the data in it. Throws Failure (bad_input) when the template has no place for
// them, or more than one.
std::string report_page(const std::string& page_template, const nlohmann::ordered_json& data);

}  // namespace driftwise::cli
