#pragma once
// "What would more terms add?" Offers groups of terms on top of a formula and says, in the figure a
// user sees, what each is worth: held-out A90 before and after, U90 with it.

#include <optional>
#include <string>
#include <vector>

#include "server/calibration/fit.h"

namespace driftwise::calibration {

struct Offer {
  std::string name;  // "cross terms position x temperature"
  std::vector<effects::Term> terms;
};

struct OfferResult {  // of one offer for one output; column unit of the output
  std::string name, output;
  std::vector<effects::Term> taken;  // of the offered: those that stepwise puts in
  std::vector<effects::Term> left;   // of the base: in before, out now
  double best_p = 1;                 // smallest p of an offered term, as the fit reports it
  std::optional<double> u90_validation_before, u90_validation_after;  // rows marked validation
  std::optional<double> u90_blocks_before,
      u90_blocks_after;                         // by blocks of time, selection repeated inside
  std::optional<double> u90_validation_forced;  // with every offered term forced in, wanted or not;
                                                // none where that cannot be fitted (rank, rows)
  // The same of A90 (server/core/data/accuracy.h): what decides.
  std::optional<double> a90_validation_before, a90_validation_after, a90_blocks_before,
      a90_blocks_after, a90_validation_forced;
  bool taken_any() const { return !taken.empty(); }
};

// One result per offer and output, in that order. Errors: those of fit(); offers already in the
// base are passed over.
Result<std::vector<OfferResult>> weigh_offers(const Dataset& dataset, const FitOptions& base,
                                              const Model& base_model,
                                              const std::vector<Offer>& offers);

// The offers of the published study for a formula's candidates: cross terms position x force (where
// a force is offered) and position x temperature, first and second derivatives of the temperatures
// (tau_s), 4th order of the pose (and 3rd, where that is not offered yet).
std::vector<Offer> published_offers(const Dataset& dataset, const Candidates& candidates,
                                    double tau_s = 600);

}  // namespace driftwise::calibration
