#pragma once
// What to do with a point after an attempt. Pure: no clock, no device, tested by table.
//
// A failed gate is read again without moving; when those reads are used up for this approach, the
// axis moves away and comes again; when those are used up for this visit, the row is queued again
// at the end of its line; when that is used up as well, the row is given up. Every attempt is on
// record whatever came of it.

#include <span>
#include <string>

#include "server/core/description/cell_description.h"
#include "server/core/records/records.h"

namespace driftwise::application {

enum class Trouble {
  none,
  spread,       // readings disagree: reading again may help
  not_settled,  // not in position or not quiet: only moving again helps
};

struct AttemptTally {
  int rereads = 0;       // since the last approach
  int reapproaches = 0;  // in this visit
  int requeues = 0;      // of this row, from the run's place
};

Verdict decide(Trouble trouble, const AttemptTally& tally, const RunRules& rules);

// The tally after the verdict, for the next attempt of the same visit.
AttemptTally after(AttemptTally tally, Verdict verdict);

// Sample standard deviation (n - 1), nm, of readings in mm; kMissing for fewer than two.
double spread_nm(std::span<const double> readings_mm);
// The same in the unit of the readings.
double standard_deviation(std::span<const double> readings);

// "spread 7.3 nm of 4 readings, limit 5 nm"
std::string spread_sentence(double spread_nm, int readings, double limit_nm);
// The same of a rotation: "spread 0.31 arcsec of 4 readings of a rotation, limit 0.2 arcsec"
std::string spread_sentence_arcsec(const std::string& channel, double spread_arcsec, int readings,
                                   double limit_arcsec);

}  // namespace driftwise::application
