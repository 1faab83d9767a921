#pragma once
// Report of a run as one page: driftwise.run-report.v1 and the page that holds it,
// docs/web-report.md. Pure.

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/core/data/accuracy.h"
#include "server/core/description/certificate_description.h"
#include "server/core/devices/device_description.h"
#include "server/core/records/audit_records.h"
#include "server/core/records/closure_records.h"
#include "server/core/records/configuration_records.h"
#include "server/core/records/diagnosis_records.h"
#include "server/core/records/queue_records.h"
#include "server/core/records/records.h"
#include "server/core/records/watch_records.h"
#include "server/core/result.h"
#include "server/diagnosis/answer/finding.h"
#include "server/diagnosis/check/verification.h"

namespace driftwise::formats {

struct ReportedModel {
  ModelId id;
  std::string name, formula;
  std::vector<JudgedAccuracy> accuracy;  // per output, on held-out rows where there are any
  struct Residuals {
    std::string output, unit;    // "q1", "nm"
    std::vector<double> values;  // one per time, measured minus model; NaN: cannot be said
  };
  std::vector<double> time_s;       // of the rows, ascending
  std::vector<std::uint8_t> check;  // 1: a validation row
  std::vector<Residuals> residuals;
  std::string trouble;  // why the model or its residuals cannot be shown; empty: they are here
};

struct ReportedDiagnosis {
  DiagnosisId id;
  std::string state, verdict, baseline, extended;  // verdict empty: it is not done
  std::vector<std::string> findings;               // sentences, the strongest first
  std::vector<std::string> left_over;              // what no cause explains: what it goes with
};

// Lists are in order of time.
struct RunReport {
  std::string cell, version, made;  // made: ISO 8601 UTC
  std::function<UtcTime(CellTime)> utc;
  RunRecord run;
  std::string compensation;  // "compensated with model 3"
  std::vector<UsedConfiguration> configurations;
  std::vector<CorrectionRecord> corrections;  // in force over its data
  ChainHead head;                             // of the record; entry 0: it has none
  std::vector<PointRecord> points;            // without those of lines measured again
  std::vector<AttemptRecord> attempts;
  std::vector<ClosureRecord> closures;
  std::vector<EventRecord> events;  // of the story's time
  std::vector<AxisDescription> axes;
  std::vector<CertificateDescription> certificates;
  std::int64_t made_utc_ns = 0;  // decides which certificate is overdue
  // What compensation achieved; nothing: a run without wanted poses.
  std::optional<diagnosis::Verification> verification;

  // The story. Entries of the queue: the run's own last, before it those that it had to wait for.
  // Empty: the run did not come from the queue.
  std::vector<QueueEntry> entries;
  std::vector<RunRecord> runs;      // of these entries, in their order
  std::vector<AlarmRecord> alarms;  // that stood while the story went on
  std::vector<ReportedModel> models;
  std::vector<ReportedDiagnosis> diagnoses;
};

nlohmann::ordered_json run_report_json(const RunReport& report);

// Little-endian float32, as base64: what the page calls packed.
std::string packed(const std::vector<double>& values);

// The template with the data in it. Errors: failed_precondition BAD_TEXT (the template has no place
// for data, or more than one).
Result<std::string> report_page(const std::string& page_template,
                                const nlohmann::ordered_json& data);

}  // namespace driftwise::formats
