#pragma once
// Parameters of a stabiliser's control loop. Plain data.

#include <optional>
#include <string>
#include <vector>

namespace driftwise {

// What is not set is not known, not declared, or stays.
struct LoopTuning {
  std::optional<double> heat_band_k, cool_band_k;  // proportional bands
  std::optional<double> integral_s, derivative_s;  // 0: off
  bool empty() const { return !heat_band_k && !cool_band_k && !integral_s && !derivative_s; }
  bool operator==(const LoopTuning&) const = default;
};

// "heat band 2 K, cool band 2 K, integral 180 s, derivative 0 s": those that are set.
std::string tuning_text(const LoopTuning& tuning);
// Sentences: what is declared and is otherwise; bands beyond 0.1 %, times beyond 0.1 s.
std::vector<std::string> differences_of(const LoopTuning& declared, const LoopTuning& found);
// The values of `with` where they are set.
LoopTuning changed(LoopTuning tuning, const LoopTuning& with);

}  // namespace driftwise
