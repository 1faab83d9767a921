#pragma once
// Sensors of the simulated cell whose output is a voltage at an input of the scanner: inclinometer,
// triangulation sensor, force sensor, current of a motor. Each sees a column of the truth.

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/simulated/plant/numbers/random.h"
#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

class VoltageSources {
 public:
  VoltageSources(std::vector<VoltageParameters> sources, std::uint64_t seed);

  bool empty() const { return sources_.empty(); }
  bool has(int input) const { return find(input) != nullptr; }
  bool sees_motors() const;
  // The friction of motors is pulled along: scale_mm of an axis now, at least ten times a second.
  void follow(const std::function<double(int axis)>& scale_mm);
  // Throws std::out_of_range naming a column that is not among the truth's.
  void check(const std::vector<std::string>& columns) const;
  // column: a value of the truth by name. scale_mm: of an axis.
  double volt(int input, const std::function<double(const std::string&)>& column,
              const std::function<double(int axis)>& scale_mm);
  // An input that shows this from now on, whatever its sensor sees; nullopt: the sensor again.
  void force(int input, std::optional<double> volt);

 private:
  struct Source {
    VoltageParameters parameters;
    Random noise;
    std::optional<double> forced_v;
    double last_mm = 0, friction_share = 0;  // -1 .. 1: how far the friction is pulled, and where
    bool begun = false;
  };
  const Source* find(int input) const;
  double seen(Source& source, const std::function<double(const std::string&)>& column,
              const std::function<double(int axis)>& scale_mm) const;

  std::vector<Source> sources_;
};

}  // namespace driftwise::simulated
