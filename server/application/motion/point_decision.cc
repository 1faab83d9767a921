#include "server/application/motion/point_decision.h"

#include <fmt/format.h>

#include <cmath>

#include "server/core/units.h"

namespace driftwise::application {

Verdict decide(Trouble trouble, const AttemptTally& tally, const RunRules& rules) {
  if (trouble == Trouble::none) return Verdict::accepted;
  if (trouble == Trouble::spread && tally.rereads < rules.max_rereads) return Verdict::reread;
  if (tally.reapproaches < rules.max_reapproaches) return Verdict::reapproach;
  if (tally.requeues < rules.max_requeues) return Verdict::requeued;
  return Verdict::given_up;
}

AttemptTally after(AttemptTally tally, Verdict verdict) {
  if (verdict == Verdict::reread) ++tally.rereads;
  if (verdict == Verdict::reapproach) {
    ++tally.reapproaches;
    tally.rereads = 0;
  }
  return tally;
}

double standard_deviation(std::span<const double> readings) {
  if (readings.size() < 2) return kMissing;
  // About the first reading: lengths are of the order of mm, what counts are nm.
  double sum = 0, sum_of_squares = 0;
  for (const double reading : readings) {
    const double d = reading - readings.front();
    sum += d;
    sum_of_squares += d * d;
  }
  const auto n = static_cast<double>(readings.size());
  return std::sqrt(std::max(0.0, (sum_of_squares - sum * sum / n) / (n - 1)));
}

double spread_nm(std::span<const double> readings_mm) {
  std::vector<double> readings_nm;  // from the first one
  for (const double reading : readings_mm)
    readings_nm.push_back(nm_from_mm(reading - readings_mm.front()));
  return standard_deviation(readings_nm);
}

std::string spread_sentence(double spread_nm, int readings, double limit_nm) {
  return fmt::format("spread {:.1f} nm of {} readings, limit {:g} nm", spread_nm, readings,
                     limit_nm);
}

std::string spread_sentence_arcsec(const std::string& channel, double spread_arcsec, int readings,
                                   double limit_arcsec) {
  return fmt::format("spread of {} {:.3g} arcsec of {} readings, limit {:g} arcsec", channel,
                     spread_arcsec, readings, limit_arcsec);
}

}  // namespace driftwise::application
