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
  // Series under each shape: whitened, freed of the base, clipped. Columns: the series of the first
  // output, then those of the second.
  struct Seen {
    Eigen::Index series = 0;                 // of one output
    std::vector<Eigen::MatrixXf> projected;  // per shape: unit length, then projected once more
    std::vector<Eigen::ArrayXd> behind;      // per shape: criterion above that of the best shape
  };

  // clip: of each whitened series, in its standard deviations.
  RandomField(const Timeline& timeline, const std::vector<NoiseShape>& shapes, const SoftBase& base,
              double clip);

  Seen see(const std::vector<Eigen::MatrixXd>& outputs) const;  // of each: rows x series
  // columns: rows x k, of about unit mean square. Outputs x series; single precision.
  Eigen::MatrixXd growth(const Eigen::MatrixXd& columns, const Seen& seen) const;

 private:
  double clip_;
  const WhitenedSpace& space(std::size_t shape, Eigen::Index spread) const {
    return spaces_[shape * static_cast<std::size_t>(spreads_) + static_cast<std::size_t>(spread)];
  }

  Eigen::Index spreads_;               // of Timeline::sd
  std::vector<WhitenedSpace> spaces_;  // per shape and spread
};

}  // namespace driftwise::diagnosis
