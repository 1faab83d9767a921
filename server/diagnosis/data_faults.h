#pragma once
// Faults of the data and the noise's spread, which no cause of the robot or an instrument is: each
// becomes a finding or a note, and is taken out of what the search looks at.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/growth/extension.h"
#include "server/diagnosis/noise/two_sides.h"
#include "server/diagnosis/rows/problem.h"
#include "server/diagnosis/rows/screen.h"
#include "server/diagnosis/rows/spread_over_places.h"

namespace driftwise::diagnosis {

class DataFaults {
 public:
  // All outlive it. It changes the problem's rows and weights, and adds to the result's findings
  // and warnings. dataset: as it was given.
  DataFaults(const Dataset& dataset, const DiagnoseOptions& options, Problem& problem,
             Diagnosis& result)
      : dataset_(dataset), options_(options), problem_(problem), result_(result) {}

  // Before the search.
  void note_sensors(const std::vector<FaultySensor>& sensors);
  void leave_out_outliers();

  // Asked where the search finds no further cause: smaller gross errors. Their rows are left out,
  // and the search is to start again without them: the noise of the rows before and after them goes
  // on as if they had not been measured. False: none.
  bool leave_out_gross_errors(const Extension& extension, const std::vector<NoiseShape>& shapes);

  // Asked where there are none: every row's own spread, with the place and from an instant on.
  // False: nothing of it.
  bool note_noise(const Extension& extension, const std::vector<NoiseShape>& shapes);

  // A spread that goes with the hour or the place, asked before a cause is named: where the noise
  // is loud its slow part is large, and a cause is found for it. The spread comes first where it
  // explains more than the cause does, and than a change at one instant, which has a name.
  bool weighed_first(const Extension& extension, const Look& look);

  // Asked where the search finds no further cause, and nothing of the above: noise with heavy
  // tails. The search then works on what each row says under the Student law that its noise
  // follows: one step of the fit by maximum likelihood, after which normal noise may be assumed. Of
  // noise with three degrees of freedom half is gone, and an effect keeps its size. Figures stay
  // those of the readings. False: nothing of it.
  bool tame_tails(const Extension& extension, const std::vector<NoiseShape>& shapes);

  // Sides that describe the readings better than the best cause does: not of averages, nor twice.
  // series: what is searched.
  std::optional<TwoSides> sides_beyond(const Look& look, const Extension& extension,
                                       const Eigen::MatrixXd& series) const;

  // The readings lie on two sides, and no cause explains them as well: the search works on what
  // they are without the sides. What is predicted of a row does not know its side.
  void free_of_sides(const TwoSides& sides, const SoftBase& simulation);

 private:
  // Complete readings beside the outputs, and the order of the rows: rows that learn x k.
  Eigen::MatrixXd channels() const;
  // Their rows, ascending, each once.
  std::vector<std::size_t> note_outliers(const std::vector<OutlierRow>& outliers);
  // A smooth field of place, time and conditions explains more than the changes of spread do: a
  // load that comes with the second grid and is not in the simulation is no noise.
  bool is_structure(const std::vector<NoiseChange>& changes, const SoftBase& simulation) const;
  // The same of any noise that explains so much in 2 ln L: one output, all together.
  bool is_structure(double of_one, double of_all, const SoftBase& simulation) const;
  void note_changes(const std::vector<NoiseChange>& changes);  // one at least
  void weigh_rows(const Spread& spread, const std::string& goes_with);

  const Dataset& dataset_;
  const DiagnoseOptions& options_;
  Problem& problem_;
  Diagnosis& result_;
  std::map<std::string, Eigen::MatrixXd> spreads_;  // by what they go with: of every dataset row
  bool time_weighed_ = false, place_weighed_ = false, tamed_ = false;
};

}  // namespace driftwise::diagnosis
