#pragma once

#include <string>
#include <vector>

#include "server/application/checks/model_checks.h"
#include "server/application/diagnoses/diagnoses.h"
#include "server/application/models/models.h"
#include "server/application/motion/workbench.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/provenance/provenance.h"
#include "server/application/report/reports.h"
#include "server/application/runs/runs.h"
#include "server/formats/report/run_report.h"

namespace driftwise::application {

class ReportsService final : public Reports {
 public:
  struct Parts {  // all of them outlive this
    Workbench& bench;
    StoreReader& reader;
    Runs& runs;
    Provenance& provenance;
    ModelChecks& checks;
    Models& models;
    Diagnoses& diagnoses;
    asio::any_io_executor background;  // for texts
  };
  // page_template: path of report.html; empty: none is installed.
  ReportsService(Parts parts, std::string version, std::string page_template);

  Awaitable<Result<std::string>> page(RunId run) override;

 private:
  Awaitable<formats::ReportedModel> model_of(ModelId id, RunId run);
  Awaitable<formats::ReportedDiagnosis> diagnosis_of(DiagnosisId id);

  Parts parts_;
  std::string version_, page_template_;
};

}  // namespace driftwise::application
