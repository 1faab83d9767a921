#pragma once
// Limits of what a cell's devices may say, as [plausibility] and [[limit]] of cell.toml declare
// them. Defaults and their sources: docs/cell-file.md. Plain data.

#include <optional>
#include <string>
#include <vector>

namespace driftwise {

// Limits of one channel, in its own unit. What is not set has the default of its kind.
struct ChannelLimitDescription {
  std::string channel;                // "t07_degC"
  std::optional<double> min, max;     // outside: impossible
  std::optional<double> max_step;     // between two successive answers, besides max_per_s
  std::optional<double> max_per_s;    // rate of change
  std::optional<int> frozen_answers;  // so many equal answers in a row: frozen; 0: never
};

struct PlausibilityRules {  // [plausibility]
  // The pose against the readback: how far the declared geometry may be from the real one.
  double geometry_um = 20.0;  // anywhere ...
  double geometry_pct = 1.0;  // ... and of the way from the zero
  // A return to zero against the last good one.
  double closure_nm = 300.0;                 // a count of fringes that slips moves by 316 nm
  std::optional<double> closure_nm_per_min;  // none: [checks] max_drift_nm_per_min
  double closure_arcsec = 2.0;
  double together_k = 0.05;  // all probes of a scanner between two scans
  std::vector<ChannelLimitDescription> limits;
};

}  // namespace driftwise
