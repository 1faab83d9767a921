#pragma once

#include "server/application/analyses/studies.h"
#include "server/application/analyses/study_desk.h"
#include "server/application/datasets/datasets.h"
#include "server/core/description/cell_description.h"

namespace driftwise::application {

class StudiesService final : public Studies {
 public:
  StudiesService(const CellDescription& description, Datasets& datasets, StudyDesk& desk)
      : description_(description), datasets_(datasets), desk_(desk) {}
  Awaitable<Result<std::vector<identification::Judgement>>> compare_methods(
      MethodsRequest request, std::shared_ptr<Study> study) override;
  Awaitable<Result<SensorChoice>> study_sensors(SensorsRequest request,
                                                std::shared_ptr<Study> study) override;

 private:
  const CellDescription& description_;
  Datasets& datasets_;
  StudyDesk& desk_;
};

}  // namespace driftwise::application
