#pragma once
// The catalogue as things to try: each cause about one subject is a list of cells, and a cell is
// one value of the unknown parameter with the columns that the effect then has.

#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/diagnosis/answer/diagnosis.h"
#include "server/effects/effect.h"
#include "server/effects/term.h"

namespace driftwise::diagnosis {

// On which scale a parameter's likelihood is about as wide everywhere.
enum class ParameterScale : std::uint8_t { none, logarithmic, inverse, instant };

// Which number of the catalogue a cause's linear coefficients are (linear_parameter.h).
enum class LinearParameter : std::uint8_t {
  none,
  nm_per_k,
  nm_per_k_per_h,
  ppm_per_k,
  nm_per_n,
  nm_per_n_per_mm,
  width_nm,
  width_arcsec,
  offset_mm,
  angle_arcsec,
  dead_path_mm,
  nm_per_h,
  size_nm
};

struct Cell {
  double parameter = 0;  // kMissing where the cause has none
  std::vector<effects::Term> terms;
  double weight = 1;  // prior of the parameter's value, up to a factor that the cause's cells share
};

struct Cause {
  std::string id;       // of the catalogue: "thermal_lag"
  std::string subject;  // "t07", "q1", "x"; "" where there is none
  std::string where;    // robot, instrument, environment, sensor or data
  effects::AppliesTo applies_to = effects::AppliesTo::robot;
  std::string parameter{};  // of the cells: "tau_s", "degree"; "" for none
  ParameterScale scale = ParameterScale::none;
  LinearParameter linear = LinearParameter::none;
  std::vector<std::string> outputs{};  // motors whose readings show it alone; empty: all together
  std::vector<Cell> cells{};
};

std::string name_of(const Cause& cause);  // "thermal_lag t07"

struct Catalogue {
  std::vector<Cause> causes;
  std::vector<NotTestable> not_testable;
};

// What the data can be asked. base: the terms that the simulation has now; excluded: symbols that
// no cause may read. A cause whose channels or variation the data lack is listed with the reason.
Catalogue catalogue_for(const Dataset& dataset, const std::vector<effects::Term>& base,
                        const std::vector<std::string>& excluded);

// Is the channel an answer of the machine rather than a condition of it: an output, anything named
// after one ("d1_std"), a length or an angle that is no coordinate? Nothing that is computed from
// an output can explain it.
bool is_response(const Channel& channel, const std::vector<std::string>& outputs);

// An error of one motor shows in its own reading and in no other motor's. Where the outputs are not
// motors (x ~ q1 + q2) it is on the way to any of them.
bool may_act_on(const Cause& cause, const std::string& output);

// The terms of a cell with another value of its parameter.
std::vector<effects::Term> with_parameter(const std::vector<effects::Term>& terms, double value);

}  // namespace driftwise::diagnosis
