#pragma once
// Questions that take long and whose answer nobody keeps: methods side by side, which thermometers
// suffice. Executor's thread.
//
// They run where diagnoses do, one after the other, so that a fit never waits for them. Whoever
// asks holds the Study; when he has lost interest he stops it, and its thread is free at the next
// fold or set of sensors.

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/application/models/fit_request.h"
#include "server/calibration/sensor_sets.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"
#include "server/identification/accuracy.h"

namespace driftwise::application {

struct StudyProgress {
  std::string step;     // "classic, 2 of 3"
  double fraction = 0;  // 0 to 1, never backwards
};

class Study {
 public:
  using Tell = std::function<void(const StudyProgress&)>;
  explicit Study(Tell to) : tell(std::move(to)) {}

  const Tell tell;  // on the executor's thread, at most twenty times a second
  // Any thread.
  void stop() { stopped_ = true; }
  bool stopped() const { return stopped_; }

 private:
  std::atomic<bool> stopped_{false};
};

struct MethodsRequest {
  FitRequest fit;                    // its formula may be empty
  std::vector<std::string> methods;  // empty: all that formula and geometry allow
  std::string robot;     // text of a robot file; empty: the geometry in the cell file, if any
  std::string together;  // rows held out together: "line" or channels; "": not done
  int folds = 10;
};

struct SensorsRequest {
  FitRequest fit;
  double tolerance = 0.1;  // of the recommendation, as a share
};

struct SensorChoice {
  calibration::SensorStudy study;
  std::string unit;  // of the outputs' columns: "mm"
};

class Studies {
 public:
  virtual ~Studies() = default;
  // Errors: those of fit() and identification::judge_method; invalid_argument NO_METHOD (neither
  // formula nor geometry), BAD_METHOD, those of formats::parse_robot_file; cancelled.
  virtual Awaitable<Result<std::vector<identification::Judgement>>> compare_methods(
      MethodsRequest request, std::shared_ptr<Study> study) = 0;
  // Errors: those of fit() and calibration::study_sensors; cancelled.
  virtual Awaitable<Result<SensorChoice>> study_sensors(SensorsRequest request,
                                                        std::shared_ptr<Study> study) = 0;
};

}  // namespace driftwise::application
