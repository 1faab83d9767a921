#pragma once
// The test of what is left that knows no cause: quadratic forms of the whitened residual over a
// dictionary of products. Each group of the dictionary is a set of smooth waves: of a pose
// coordinate, of pairs and triples of them, of the temperatures, force and air, the direction of
// approach, and the places one by one; each is multiplied by waves in the order of the rows, band
// by band. Correlations of neighbouring rows, in time and at neighbouring places, are asked
// two-sided. The lines of the plan are asked each by itself, as a whole and for what is only at
// their beginning: a robot that rests between lines, or is zeroed there, begins each one afresh.
//
// Narrow families (the groups, an axis' slow waves alone, a direction alone, an axis with its
// places in the rows before) are asked as random fields too (random_field.h): the noise may be
// another one with the field, so that slow noise does not hide a slow field.
//
// Judge: the largest standardised form and the root of the largest growth by a field, of one output
// and of the sums over all outputs, each in units of its spread over all series; the largest of
// these against series simulated from the fitted noise that go through the same projection of
// baseline and findings. Residuals are clipped at 3.5 standard deviations in the data and in the
// simulated series, so that heavy tails are noise. No output and nothing computed from one is in
// the dictionary.
//
// Source: NUMERICS.md section 4 (the shapes); the p-value is the rank among exchangeable series
// (Barnard 1963), data included in the standardisation.

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/noise/random_field.h"
#include "server/diagnosis/noise/soft_base.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// What the test would have seen in 80 % of cases, to first order.
struct SmallestSeen {
  std::string shape, output, unit;
  double rms = 0;
};

struct OmnibusResult {
  double p = 1;
  int nulls = 0;
  std::string where;                   // "x with time, at x near 2.5 mm, in rows 1 to 250"
  std::vector<SmallestSeen> smallest;  // only where nothing is left
};

// Level: half of 1 %, for the held-out rows' means and single variables are asked too, and all
// tests of what is left together are to alarm in 1 % of noise. 199 series decide where none of
// them, or more than three, are as large as the data; else there are more.
inline constexpr double kOmnibusLevel = 0.005;
inline constexpr int kOmnibusNulls = 999;

struct OmnibusOptions {
  double level = kOmnibusLevel;
  int nulls = kOmnibusNulls;
  std::uint64_t seed = 1;
  std::function<bool()> tick;  // false: stop
};

// To 0 .. 1; empty where it does not vary.
Eigen::VectorXd unit_range(const Eigen::VectorXd& values);

class Omnibus {
 public:
  // problem: every row that is to be asked learns; it outlives this.
  Omnibus(const Problem& problem, const Eigen::MatrixXd& series,
          const std::vector<std::string>& excluded);

  // Nothing: stopped.
  std::optional<OmnibusResult> test(const SoftBase& base, const OmnibusOptions& options);
  // Growth of 2 ln L by the likeliest field: of one output, and of all together.
  struct FieldGain {
    double of_one = 0, of_all = 0;
  };
  FieldGain likeliest_field(const SoftBase& base) const;
  // Of the form that a finding takes most of (without: the base without it): the share that is left
  // with it in. After a test.
  double share_left(const SoftBase& with, const SoftBase& without) const;

 private:
  struct Group {
    std::string name;
    Eigen::MatrixXf waves;          // rows x k; empty: the places
    std::vector<std::string> of{};  // the variables, for words
  };
  struct Band {
    Eigen::Index first = 0, count = 0;
    const char* words = "";
  };
  // Families that are quadratic forms: group by band, then those of the lines.
  Eigen::Index quadratic() const {
    return static_cast<Eigen::Index>(groups_.size() * bands_.size()) + line_waves_.cols();
  }
  // Forms of every family for every series: families x series, first the quadratic ones, then the
  // correlations.
  Eigen::MatrixXd forms(const Eigen::MatrixXf& left) const;
  struct Where {
    std::size_t field = 0, band = 0;
    Eigen::Index output = 0;  // the one with most of it
  };
  // By a field: square root of the growth of 2 ln L, the largest of all families, per series.
  struct Grown {
    Eigen::VectorXd of_one{}, of_all{};  // of one output; summed over the outputs
    Where where_one{}, where_all{};      // of the first series, which is the data
  };
  // Forms (the quadratic ones by their cube roots) in units of their spread over the series.
  struct Standardised {
    Eigen::VectorXd mean{}, sd{};  // per family, before
    Eigen::VectorXd largest{};     // per series, of all families
    Eigen::VectorXd of_data{};     // per family, of the first series
    std::size_t family = 0;        // its largest
  };
  Standardised standardise(Eigen::MatrixXd values) const;
  std::vector<NoiseShape> shapes_with_a_field(const Ground& ground) const;
  // series: of each output. Nothing: stopped.
  std::optional<Grown> grown(const RandomField& field, const std::vector<Eigen::MatrixXd>& series,
                             const std::function<bool()>& tick) const;
  Eigen::MatrixXf white(const SoftBase& base, Eigen::Index output, const NoiseShape& shape,
                        const Eigen::MatrixXd& series) const;
  std::string of_output(Eigen::Index output) const;
  std::string words(std::size_t family, Eigen::Index output, const Eigen::VectorXf& left) const;
  std::string words(const Group& group, const Band& band, Eigen::Index output,
                    const Eigen::VectorXf& left) const;
  std::vector<SmallestSeen> smallest(const SoftBase& base) const;
  void add_groups(const std::vector<std::string>& excluded);
  void add_lines();

  static constexpr Eigen::Index kLags = 3;  // of rows that resemble one another

  const Problem& problem_;
  const Eigen::MatrixXd& series_;
  std::vector<Group> groups_;
  std::vector<Group> fields_;  // asked as random fields
  std::vector<Band> bands_;
  Eigen::MatrixXf time_waves_;
  std::vector<std::size_t> place_of_;
  std::size_t place_count_ = 0;
  std::vector<Eigen::Index> by_place_;                        // rows, place after place
  std::vector<std::pair<Eigen::Index, Eigen::Index>> lines_;  // first row and number of rows
  Eigen::MatrixXf line_waves_;                                // rows x k; no columns: no lines
  std::vector<NoiseShape> noise_;                             // of the last test, per output
  std::vector<double> white_sd_;
  std::vector<Eigen::VectorXd> mean_, sd_;  // of the cube roots of the forms, per output
  double limit_ = 0;                        // standardised, at the level
};

}  // namespace driftwise::diagnosis
