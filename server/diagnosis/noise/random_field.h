#pragma once
// Growth of 2 ln L when a field of random amplitudes joins the noise: the covariance of the rows is
// then that of the noise plus rho / k of F F', F the k columns of the field. rho, the field's
// variance over that of the white noise, is the likeliest of a grid, and the noise with the field
// is free to be another shape than the noise without it: slow noise that has taken up the field
// gives it back.
//
// Source: Patterson and Thompson, Biometrika 58 (1971) 545 (restricted likelihood of a variance
// component). The growth's law where there is no field is left to series simulated from the noise.

#include <Eigen/Core>
#include <vector>

#include "server/diagnosis/noise/noise_model.h"
#include "server/diagnosis/noise/soft_base.h"
#include "server/diagnosis/noise/whitened_space.h"

namespace driftwise::diagnosis {

class RandomField {
 public:
  // Series of one output under each shape: whitened, freed of the base, clipped.
  struct Seen {
    std::vector<Eigen::MatrixXd> left;  // per shape: rows x series
    Eigen::MatrixXd squares;            // shapes x series
    Eigen::ArrayXd without;             // per series: lowest criterion over the shapes
  };

  // clip: of each whitened series, in its standard deviations.
  RandomField(const Timeline& timeline, const std::vector<NoiseShape>& shapes, const SoftBase& base,
              double clip);

  Seen see(const Eigen::MatrixXd& series) const;  // rows x series
  // columns: rows x k, of about unit mean square. Outputs x series.
  Eigen::MatrixXd growth(const Eigen::MatrixXd& columns, const std::vector<Seen>& outputs) const;

 private:
  double clip_;
  std::vector<WhitenedSpace> spaces_;
};

}  // namespace driftwise::diagnosis
