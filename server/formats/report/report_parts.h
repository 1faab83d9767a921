#pragma once
// Parts of a report's JSON that its files share.

#include <cmath>
#include <nlohmann/json.hpp>

#include "server/formats/report/run_report.h"

namespace driftwise::formats {

// ISO 8601 UTC; null: not yet.
nlohmann::ordered_json report_time(const RunReport& report, CellTime at);
nlohmann::ordered_json finite_or_null(double value);
nlohmann::ordered_json report_figures(const ErrorFigures& figures);
nlohmann::ordered_json report_judged(const JudgedAccuracy& judged);

// Keys "queue", "alarms", "models" and "diagnoses".
void add_story(const RunReport& report, nlohmann::ordered_json& out);

}  // namespace driftwise::formats
