#pragma once

#include <string>

#include "tests/hidden_effects/foreign/generate.h"

namespace driftwise::foreign {

// How a data set is written: names and units of its columns.
struct Dress {
  // study, or random.
  std::string kind;
  std::string motor_length = "mm";
  std::string motor_angle = "arcsec";
  std::string pose_length = "mm";
  std::string pose_angle = "arcsec";
  std::string temperature = "degC";
  std::string pressure = "hPa";
  std::string activity = "speed_1";
  std::vector<std::string> thermometers;

  std::string symbol_of(const std::string& study_symbol) const;
};

Dress dress_of(const Generated& made);

// Factor from mm or arcsec to a unit. Throws std::runtime_error for an unknown one.
double per_internal(const std::string& unit);

// Data set in the format of DESIGN.md section 4.
std::string dataset_csv(const Generated& made, const Dress& dress);
// Baseline formula to give to the diagnosis.
std::string baseline_formula(const Generated& made, const Dress& dress);
// Key: one line of JSON.
std::string key_json(const Generated& made, const Dress& dress, const std::string& file);

}  // namespace driftwise::foreign
