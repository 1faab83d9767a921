#pragma once
// What a person has to answer before a model serves. Sentences that follow "although". Pure.

#include <functional>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/description/cell_description.h"
#include "server/core/records/diagnosis_records.h"
#include "server/core/records/run_metadata.h"
#include "server/core/result.h"
#include "server/core/utc_map.h"
#include "server/formats/cell_file/cell_file_difference.h"

namespace driftwise::application {

// Thermometers that are not on the robot (their `part` says so) in terms that are in: what an
// instrument or the air does to the reading would be served as if the robot did it.
std::vector<std::string> temperature_questions(const calibration::Model& model,
                                               const CellDescription& cell);

// Corrections that the model rests on and that were taken back since, for good: accepted again, the
// same one is in force. utc: of an instant of cell time.
std::vector<std::string> correction_questions(const std::vector<CorrectionRecord>& rests_on,
                                              const std::function<UtcTime(CellTime)>& utc);

// Changes of the cell file since the model was measured, in a part that it uses.
std::vector<std::string> configuration_questions(
    const calibration::Model& model, const std::vector<formats::ConfigurationChange>& since);

// A model of runs whose campaign states a wanted accuracy (server/core/records/wanted_accuracy.h,
// of several runs the smallest): outputs that miss it, or that it was judged on no validation rows.
// A robot's geometry that no data judged is asked about that alone: imported_geometry_questions.
std::vector<std::string> accuracy_questions(const calibration::Model& model,
                                            const std::vector<RunMetadata>& of_its_runs);

// A robot file as it was imported, which no data judged.
std::vector<std::string> imported_geometry_questions(const calibration::Model& model);

// Symbols of what the model reads or was identified from, each once: its outputs, its included
// terms and, of a geometry, the pose, the motors and the thermometers of its joints' drifts.
std::vector<std::string> symbols_used(const calibration::Model& model);

// Errors: failed_precondition NEEDS_CONFIRMATION, where there is a question.
Result<void> confirmation_of(const std::vector<std::string>& questions);
// Errors: failed_precondition REASON_REQUIRED, where there is a question.
Result<void> reason_for(const std::vector<std::string>& questions);

}  // namespace driftwise::application
