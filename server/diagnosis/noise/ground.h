#pragma once
// What a search for one more cause stands on: the present simulation's columns under each shape of
// noise that is in question, and the measured series of each output. Everything that asks "how much
// better with this" does so here, and with the noise free to be another one with it than without:
// a slow effect that the noise has swallowed is given back.

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "server/diagnosis/noise/noise_model.h"
#include "server/diagnosis/noise/white_sd.h"
#include "server/diagnosis/noise/whitened_space.h"

namespace driftwise::diagnosis {

// One effect's columns beyond a base: an orthonormal basis, fewer columns where they are already
// there (less than 1e-4 of the length is left) or alike.
Eigen::MatrixXd beyond(const WhitenedSpace& space, const Eigen::MatrixXd& columns);

// Gaussian prior of an effect's amplitudes: columns x outputs, standard deviation in the output's
// summary unit per unit of the column. 0: does not act there.
using PriorSd = Eigen::MatrixXd;

// An amplitude's size is known to two or three orders of magnitude, for a good machine's effects
// are far below a typical one's: its prior is, with equal odds, each of these shares of the typical
// standard deviation; where a cause may act on several outputs also
// none at all, for it need not act on all of them.
inline constexpr std::array<double, 4> kPriorShares = {1, 0.125, 0.0156, 0.002};
// 2 ln of the marginal likelihood's ratio under each share of the prior's width.
using ByShare = std::array<double, kPriorShares.size()>;
// 2 ln of the mean over the shares, and over "does not act" where that is possible.
double averaged(const ByShare& two_ln, bool may_not_act);
// Mode of the posterior over the shares, whose odds are equal; of equals the widest. 0: does not
// act, where that is likelier than that it acts with any of the shares, at equal odds.
double likeliest_share(const ByShare& two_ln, bool may_not_act);

// A column of which the simulation's columns leave less than this share of its whitened length says
// nothing of its effect: no shape is known better. x * t at 20 degC that change by 0.1 K leaves
// 5e-3.
inline constexpr double kLeastNew = 1e-3;

// Whitened columns (rows x k, centred) with the simulation's taken out; zero where less than
// kLeastNew of the length is left.
Eigen::MatrixXd news_of(const WhitenedSpace& space, Eigen::MatrixXd columns);

// Price in 2 ln L of an output's noise with a shape of its own. The outputs of one robot are read
// by the same instruments in the same air, one after the other: their noise has one shape and a
// size each. That one output departs from it is a claim about that output as a named cause is, and
// is believed on the same terms: at alpha = 0.003 after the choice among the ten shapes of the grid
// that can be told apart, 2 ln(10 / 0.003). Cheaper, it takes up any slow effect on one output.
inline constexpr double kOwnShape = 16.2;

// Price in 2 ln L of correlated noise beside white noise, at even odds: it is chosen among ten
// shapes that can be told apart, and the likeliest of them stands for their mean, 2 ln 10. Without
// it a drift or a jump in white noise was as good as one slow noise among ten that imitate it.
inline constexpr double kCorrelatedNoise = 4.6;
double price_of(const NoiseShape& shape, Eigen::Index outputs);  // for each of them

// Shapes of the outputs' noise, chosen together.
struct SharedShape {
  double total = 0;                // criterion of all outputs, with the cost of own shapes
  std::vector<std::size_t> shape;  // per output
};
// criterion: shapes x outputs, twice the negative log-likelihood of each alone.
SharedShape shared_shape(const Eigen::MatrixXd& criterion);

// Variance of the outputs' noise in the direction of their gains: so many times one chance counts
// in a sum over outputs. 1: the outputs are independent, or one gains alone. The number of outputs:
// one instrument's noise is in all of them, as behind the legs of a hexapod. of_output: 2 ln L.
// alike: outputs_alike().
double counted_times(const Eigen::Ref<const Eigen::VectorXd>& of_output,
                     const Eigen::MatrixXd& alike);
// Correlation between outputs in size, less twice its standard error of n rows.
Eigen::MatrixXd outputs_alike(const Eigen::MatrixXd& correlation, double n);

// gain, likelihood: of all outputs, each chance counted once (counted_times()).
struct Gain {
  double gain = 0;        // 2 ln of the marginal likelihood's ratio, with the effect to without it
  double likelihood = 0;  // growth of 2 ln L at the best amplitudes within three prior widths
  std::vector<double> of_output;              // of gain
  std::vector<double> share;                  // of the prior's width, per output: likeliest_share()
  std::vector<std::size_t> shape;             // of the noise with the effect, per output
  std::vector<Eigen::VectorXd> contribution;  // per output, whitened; empty: not asked
};

class Ground {
 public:
  // base: rows x k; series: rows x outputs. tick: asked between shapes; where it says
  // false the ground has fewer of them and its owner is to stop.
  Ground(const Timeline& timeline, const std::vector<NoiseShape>& shapes, const SoftBase& base,
         const Eigen::MatrixXd& series, const std::function<bool()>& tick = {});

  std::size_t shape_count() const { return left_.size(); }
  Eigen::Index outputs() const { return series_.cols(); }
  const NoiseShape& shape(std::size_t at) const { return in_spread(at, 0).shape(); }
  // Outputs whose rows are spread alike share their spaces.
  const WhitenedSpace& space(std::size_t shape, Eigen::Index output) const {
    return in_spread(shape, spread_of(output));
  }
  // Of Timeline::sd.
  Eigen::Index spreads() const { return spreads_; }
  Eigen::Index spread_of(Eigen::Index output) const { return spreads_ > 1 ? output : 0; }
  const WhitenedSpace& in_spread(std::size_t shape, Eigen::Index spread) const {
    return spaces_[shape * static_cast<std::size_t>(spreads_) + static_cast<std::size_t>(spread)];
  }
  const Eigen::MatrixXd& series() const { return series_; }
  std::size_t best_shape(Eigen::Index output) const {
    return best_[static_cast<std::size_t>(output)];
  }
  const NoiseShape& noise(Eigen::Index output) const { return shape(best_shape(output)); }
  WhiteSd white_sd(Eigen::Index output) const;
  // Of the white noise with an effect in, under the shape that is best with it.
  WhiteSd white_sd_with(const Gain& effect, Eigen::Index output) const;
  // How much worse a shape explains an output than the one that it has, in 2 ln L; negative where
  // the outputs together chose another one.
  double worse_by(std::size_t shape, Eigen::Index output) const;
  // Correlation between the outputs of what is left, whitened.
  Eigen::MatrixXd correlation() const;
  // The part of it beyond chance: outputs_alike().
  const Eigen::MatrixXd& alike() const { return alike_; }

  // columns: rows x c, centred or not. Amplitudes are integrated out under their prior.
  Gain gain(const Eigen::MatrixXd& columns, const PriorSd& prior) const;
  // The same, priors weighed against the noise that is left with the effect in: what is not named
  // yet is noise to the first look, and slow noise may have taken it up.
  Gain settled_gain(const Eigen::MatrixXd& columns, const PriorSd& prior) const;
  // The same with free amplitudes: growth of 2 ln L alone, for shapes that no physics describes.
  Gain free_gain(const Eigen::MatrixXd& columns, const std::vector<char>& on) const;
  // Posterior mean and standard error of the amplitudes on one output.
  struct Amplitudes {
    Eigen::VectorXd mean, error;
  };
  Amplitudes amplitudes(const Eigen::MatrixXd& columns, const PriorSd& prior, std::size_t shape,
                        Eigen::Index output) const;

 private:
  Eigen::MatrixXd series_;
  Eigen::Index spreads_ = 1;
  std::vector<WhitenedSpace> spaces_;  // per shape and spread
  std::vector<Eigen::MatrixXd> left_;  // per shape: of the series
  Eigen::MatrixXd criterion_;          // shapes x outputs
  std::vector<std::size_t> best_;      // by it
  Eigen::MatrixXd priced_;             // with the price of correlated noise: what gains go by
  std::vector<std::size_t> best_priced_;
  double total_ = 0;  // priced, of all outputs together
  Eigen::MatrixXd alike_;
};

}  // namespace driftwise::diagnosis
