#pragma once
// Search for errors of an arm's joints beyond every number of its drawing.
//
// One amplitude turns a joint and moves all outputs, so a cause is one or two columns over all
// outputs together (whitened_geometry.h). Every number of the drawing that such data determine is
// in beside it without a prior, so what a drawing could explain is not offered as a cause.
//
// Least squares of the rows as they are: what a drawing does not have is an error of the pose,
// smooth over the workspace, and a noise model in time would take it away where poses follow one
// another. Rows are correlated for the same reason: a cause's evidence counts them as fewer by the
// ratio of the variance of its score over 60 short blocks of time to that of independent rows
// (Liang, Zeger, Biometrika 73 (1986) 13).
//
// Evidence: the marginal likelihood under the prior of arm_causes.h, at the widths kPriorShares.
// Gravity acts on every arm: sag of all joints is in, under its prior, when another cause is asked.
// A cause is named where its ratio of marginal likelihoods exceeds its price over alpha: the mean
// of such a ratio is 1 where nothing is hidden, so by Markov's inequality a false name is rarer
// than alpha. The price is twice the number of causes that act on every arm, or twice that of the
// others.
//
// Gate: the predictive log density of rows left out must rise over blocks of time, over
// groups of neighbouring joint angles, and over six parts of what the cause is a function of
// (angle, torque, temperature). The amplitude of a cause that need not act (all but sag) must also
// be the same without any of the six parts: it exceeds its own standard error by the jackknife over
// them (Student's t, one-sided 5 %). One part alone that asks for it, or parts that disagree, are
// another cause's likeness. One that fails alone may enter with a second, where either passes with
// the other in.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "server/diagnosis/robot/arm_causes.h"
#include "server/diagnosis/robot/whitened_geometry.h"

namespace driftwise::diagnosis {

struct ArmGate {
  double by_time = 0, by_places = 0, by_driver = 0;  // growth of 2 ln of the predictive density
  double t_by_driver = 0;  // amplitude over its standard error, from leaving out each of six parts
  bool passes = false;
};

struct NamedArmCause {
  std::size_t cause = 0;      // in the catalogue
  Eigen::VectorXd amplitude;  // posterior mean, per column of its turns
  Eigen::VectorXd error;      // posterior standard deviation
  double two_ln_bf = 0, p_adjusted = 1, gain_2lnl = 0;
  std::vector<std::size_t> rivals{};  // that come within 6 in its place
  ArmGate gate;
};

struct RefusedArmCause {
  std::size_t cause = 0;
  double two_ln_bf = 0;
  ArmGate gate;
};

class ArmSearch {
 public:
  // geometry: columns in without a prior. whole: its last columns are the turns of `causes`, in
  // their order. angles: learning rows x joints, scaled alike. All outlive it.
  ArmSearch(const WhitenedGeometry& whole, const std::vector<Eigen::Index>& geometry,
            const std::vector<ArmCause>& causes, Eigen::MatrixXd angles,
            const std::vector<std::size_t>& learn);

  void search(double alpha);
  const std::vector<NamedArmCause>& named() const { return named_; }  // strongest first
  const std::vector<RefusedArmCause>& refused() const { return refused_; }
  // Causes with which the judging rows were described worse.
  const std::vector<std::size_t>& withdrawn() const { return harmful_; }

  // Amplitude from which such rows show the cause beside the numbers of the drawing, in its units.
  double least_shown(std::size_t cause) const;

  // Coefficients of all columns of `whole` with the named causes in; without: but this cause.
  Eigen::VectorXd coefficients(std::size_t without = kNone) const;

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

 private:
  struct Soft {  // a cause in under a prior
    std::size_t cause;
    double share;  // of its typical size
  };
  struct Fit {
    double two_ln = 0;            // of the marginal likelihood, up to a constant
    double explained = 0;         // of the whitened sum of squares, shrunk by the prior
    Eigen::VectorXd mean, error;  // per column, in units of its prior's width
  };
  Eigen::Index first(std::size_t cause) const { return first_[cause]; }
  Eigen::Index width(std::size_t cause) const { return causes_[cause].turns_rad.cols(); }
  std::vector<Eigen::Index> columns_of(const std::vector<Soft>& soft) const;
  Eigen::VectorXd scales_of(const std::vector<Soft>& soft) const;
  // rows_per_row: rows that count as one.
  Fit fit(const std::vector<Soft>& soft, double rows_per_row) const;
  // The noise by what the causes that are in leave: a strong one, once in, is none of it.
  void weigh_again();
  double correlation_of(std::size_t cause) const;
  // Beside what is named and every certain cause.
  std::vector<Soft> beside(std::size_t cause) const;
  struct Evidence {
    double two_ln = 0, share = 1, likelihood = 0;
    bool nameable = false;  // sign and size are the cause's
  };
  Evidence evidence(std::size_t cause, const std::vector<Soft>& base) const;
  double chance_of(std::size_t cause, double two_ln) const;  // after the price of looking at all
  ArmGate gate(std::size_t cause, const std::vector<Soft>& base, double share) const;
  std::optional<Soft> companion(const Soft& one, const std::vector<char>& ruled_out) const;
  std::optional<std::size_t> index_of(std::size_t cause) const;
  void enter(std::vector<char>& ruled_out);
  std::optional<std::size_t> harmful() const;
  void describe();

  const WhitenedGeometry& whole_;
  std::vector<Eigen::Index> geometry_;
  const std::vector<ArmCause>& causes_;
  Eigen::MatrixXd angles_;
  std::vector<std::size_t> learn_;
  std::vector<Eigen::Index> first_;  // of each cause's columns among the turns
  Eigen::MatrixXd basis_;            // orthonormal, of the geometry
  Eigen::MatrixXd turns_;            // beyond the basis
  Eigen::VectorXd y_;                // beyond the basis, in units of the noise
  double noise_ = 1;
  std::vector<double> typical_;  // of each cause: of its prior, in its units
  Eigen::MatrixXd gram_;
  Eigen::VectorXd along_;
  std::vector<double> correlated_;  // of each cause: rows that count as one
  Eigen::Index rows_ = 0, outputs_ = 1;
  double alpha_ = 0.003;
  std::vector<Soft> in_;
  std::vector<NamedArmCause> named_;
  std::vector<RefusedArmCause> refused_;
  std::vector<std::size_t> harmful_;
};

}  // namespace driftwise::diagnosis
