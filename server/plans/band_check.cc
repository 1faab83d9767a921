#include "server/plans/band_check.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>

#include "server/core/text/shown_text.h"
#include "server/plans/band_poses.h"
#include "server/plans/band_ranges.h"
#include "server/plans/joint_target.h"

namespace driftwise::plans {
namespace {

using compensation::Snapshot;
using compensation::Variable;
using Jacobian = Eigen::MatrixXd;  // outputs by inputs, mm per request's unit

constexpr int kDirections = 24;  // over half a turn among two angles
// What may lie between two points of the grid, and between two directions.
constexpr double kBetween = 1.05;

std::vector<Variable> inputs_of(const JointSnapshot::Robot& robot) {
  std::vector<Variable> out;
  for (std::size_t v = 0; v < compensation::kVariables; ++v)
    if ((robot.needed >> v & 1) != 0) out.push_back(static_cast<Variable>(v));
  return out;
}

template <class Give>
Jacobian jacobian_of(std::size_t outputs, const std::vector<Variable>& inputs,
                     const std::vector<double>& step, const Values& pose, const Give& give) {
  Jacobian out(static_cast<Eigen::Index>(outputs), static_cast<Eigen::Index>(inputs.size()));
  std::array<double, compensation::kMaxOutputs> above{}, below{};
  for (std::size_t j = 0; j < inputs.size(); ++j) {
    Values moved = pose;
    double& value = moved[static_cast<std::size_t>(inputs[j])];
    const double at = value;
    value = at + step[j];
    give(moved, above.data());
    value = at - step[j];
    give(moved, below.data());
    for (std::size_t i = 0; i < outputs; ++i)
      out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          (above[i] - below[i]) / (2 * step[j]);
  }
  return out;
}

// Directions of a path, as columns over the inputs: turns among the angles of the band, and each
// length of it alone.
std::vector<Eigen::VectorXd> directions_of(const JointSnapshot::Robot& robot,
                                           const std::vector<Variable>& inputs) {
  std::vector<Eigen::Index> angles, lengths;
  for (std::size_t j = 0; j < inputs.size(); ++j)
    for (std::size_t p = 0; p < robot.band.parts; ++p)
      if (robot.band.part[p].coordinate == inputs[j])
        (is_rotation(inputs[j]) ? angles : lengths).push_back(static_cast<Eigen::Index>(j));
  const auto none = [&] {
    return Eigen::VectorXd(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(inputs.size())));
  };
  std::vector<Eigen::VectorXd> out;
  const auto along = [&](Eigen::Index j) {
    auto one = none();
    one(j) = 1;
    out.push_back(one);
  };
  for (const auto j : lengths) along(j);
  if (angles.size() == 1) along(angles.front());
  for (std::size_t a = 0; a < angles.size(); ++a)
    for (std::size_t b = a + 1; b < angles.size(); ++b)
      for (int k = 0; k < kDirections; ++k) {
        auto one = none();
        one(angles[a]) = std::cos(std::numbers::pi * k / kDirections);
        one(angles[b]) = std::sin(std::numbers::pi * k / kDirections);
        out.push_back(one);
      }
  return out;
}

// Figures of one pose.
struct Seen {
  double difference_nm = 0;
  std::vector<double> share;  // of a rate, by direction
  double determinant = std::numeric_limits<double>::infinity();
};

class Look {
 public:
  Look(const JointSnapshot::Robot& robot, std::int64_t most_poses)
      : robot_(robot),
        inputs_(inputs_of(robot)),
        outputs_(robot.fine.outputs.size()),
        directions_(directions_of(robot, inputs_)),
        poses_(robot, inputs_, most_poses) {
    for (const auto variable : inputs_) {
      double width = 0;
      for (std::size_t p = 0; p < robot.band.parts; ++p)
        if (robot.band.part[p].coordinate == variable)
          width = robot.band.part[p].to - robot.band.part[p].from;
      const Range range = range_of(*robot.coarse, variable);
      steps_.push_back(1e-4 * (width > 0 ? width : std::max(1e-3, range.max - range.min)));
    }
    for (const auto& direction : directions_)
      families_.push_back(static_cast<std::size_t>(
          std::ranges::find_if(directions_,
                               [&](const Eigen::VectorXd& other) {
                                 return ((other.array() != 0) == (direction.array() != 0)).all();
                               }) -
          directions_.begin()));
    out_.robot = robot.id;
    out_.anchored = robot.band.anchored;
  }

  BandReport report() {
    look_at_models();
    look_at_blend([](const BandReport&) { return true; });
    climb_from_worst();
    out_.poses = poses_.seen();
    out_.whole_grid = poses_.is_whole();
    return out_;
  }

  // As report().accepted(), and no pose more once one refuses.
  bool accepted() {
    look_at_models();
    look_at_blend([](const BandReport& so_far) { return so_far.accepted(); });
    if (out_.accepted()) climb_from_worst();
    return out_.accepted();
  }

 private:
  using Place = BandPoses::Place;
  // Climbs of a figure: from so many regions.
  static constexpr std::size_t kClimbs = 8;

  bool square() const { return outputs_ == inputs_.size(); }

  // Largest rates of the fine model, which shares count in, and where the two are farthest apart. A
  // largest rate that the poses miss makes the shares larger: the check errs towards refusing.
  void look_at_models() {
    largest_rate_ = std::vector<double>(directions_.size(), 0.0);
    WorstPlaces apart;
    poses_.visit([&](const Values& pose, const Place& place) {
      if (fine_weight(robot_.band, pose) <= 0) return true;
      const Jacobian fine = of_model(robot_.fine, pose);
      for (std::size_t d = 0; d < directions_.size(); ++d)
        largest_rate_[d] =
            std::max(largest_rate_[d], (fine * directions_[d]).cwiseAbs().maxCoeff());
      apart.add(poses_.region_of(pose), see_difference(pose), place);
      return true;
    });
    if (poses_.is_whole()) return;
    for (const auto& place : apart.first(1))
      poses_.climb(place, [&](const Values& pose) { return see_difference(pose); });
  }

  // go_on: asked after every pose.
  void look_at_blend(const std::function<bool(const BandReport&)>& go_on) {
    worst_share_.clear();
    poses_.visit([&](const Values& pose, const Place& place) {
      const Seen seen = see_blend(pose);
      if (!poses_.is_whole()) remember(poses_.region_of(pose), seen, place);
      return go_on(out_);
    });
  }

  void remember(std::size_t region, const Seen& seen, const Place& place) {
    for (std::size_t d = 0; d < directions_.size(); ++d)
      worst_share_[families_[d]].add(region, seen.share[d], place);
    if (square()) worst_determinant_.add(region, -seen.determinant, place);
  }

  // The worst of the whole grid, where only a part of it was visited.
  void climb_from_worst() {
    if (poses_.is_whole()) return;
    for (const auto& place : worst_determinant_.first(kClimbs))
      poses_.climb(place, [&](const Values& pose) { return -see_blend(pose).determinant; });
    for (const auto& [family, worst] : worst_share_)
      for (const auto& place : worst.first(kClimbs))
        poses_.climb(place, [&, of = family](const Values& pose) {
          const Seen seen = see_blend(pose);
          double largest = 0;
          for (std::size_t d = 0; d < directions_.size(); ++d)
            if (families_[d] == of) largest = std::max(largest, seen.share[d]);
          return largest;
        });
  }

  Jacobian of_model(const Snapshot& model, const Values& pose) const {
    return jacobian_of(outputs_, inputs_, steps_, pose,
                       [&](const Values& p, double* out) { model_coordinates(model, p, out); });
  }

  // Of the two models as fitted, in the output where they are farthest apart, nm.
  double see_difference(const Values& pose) {
    if (fine_weight(robot_.band, pose) <= 0) return 0;
    std::array<double, compensation::kMaxOutputs> a{}, b{};
    model_coordinates(robot_.fine, pose, a.data());
    model_coordinates(*robot_.coarse, pose, b.data());
    Eigen::VectorXd apart(static_cast<Eigen::Index>(outputs_));
    std::size_t worst = 0;
    for (std::size_t i = 0; i < outputs_; ++i) {
      apart(static_cast<Eigen::Index>(i)) = b[i] - a[i];
      if (std::abs(b[i] - a[i]) > std::abs(b[worst] - a[worst])) worst = i;
    }
    const double nm = std::abs(b[worst] - a[worst]) * kNmPerMm;
    if (nm <= out_.largest_difference_nm) return nm;
    out_.largest_difference_nm = nm;
    out_.largest_channel = channel_name(robot_.id, robot_.fine.outputs[worst].channel.name());
    out_.largest_at.clear();
    for (const auto variable : inputs_)
      out_.largest_at.push_back(
          {channel_name(robot_.id, variable), pose[static_cast<std::size_t>(variable)]});
    out_.difference_arcsec = 0;
    if (!square()) return nm;
    const Eigen::VectorXd moved = of_model(robot_.fine, pose).fullPivLu().solve(apart);
    double squares = 0;
    for (std::size_t j = 0; j < inputs_.size(); ++j)
      if (is_rotation(inputs_[j]))
        squares += moved(static_cast<Eigen::Index>(j)) * moved(static_cast<Eigen::Index>(j));
    out_.difference_arcsec = std::sqrt(squares);
    return nm;
  }

  Seen see_blend(const Values& pose) {
    const bool in_band = fine_weight(robot_.band, pose) > 0;
    const Jacobian reference = of_model(in_band ? robot_.fine : *robot_.coarse, pose);
    const Jacobian blended =
        jacobian_of(outputs_, inputs_, steps_, pose,
                    [&](const Values& p, double* q) { robot_coordinates(robot_, p, q); });
    const Jacobian deviation = blended - reference;
    Seen seen;
    for (std::size_t d = 0; d < directions_.size(); ++d) {
      seen.share.push_back(kBetween * (deviation * directions_[d]).cwiseAbs().maxCoeff() /
                           std::max(largest_rate_[d], 1e-300));
      out_.rate_share = std::max(out_.rate_share, seen.share.back());
    }
    if (!square()) return seen;
    seen.determinant = blended.determinant() / reference.determinant();
    if (std::isfinite(seen.determinant))
      out_.determinant_share =
          std::min(out_.determinant_share.value_or(seen.determinant), seen.determinant);
    return seen;
  }

  const JointSnapshot::Robot& robot_;
  std::vector<Variable> inputs_;
  std::size_t outputs_;
  std::vector<Eigen::VectorXd> directions_;
  std::vector<std::size_t> families_;  // of a direction: the first one among the same inputs
  BandPoses poses_;
  std::vector<double> steps_, largest_rate_;
  std::map<std::size_t, WorstPlaces> worst_share_;  // by family
  WorstPlaces worst_determinant_;
  BandReport out_;
};

double reach_of_model(const Snapshot& model, const BandPart& part) {
  const Range range = range_of(model, part.coordinate);
  return reach_of(part, range.min, range.max);
}

// The band `times` as wide outward, as far as both models reach; false: they do not.
bool widen(JointSnapshot::Robot& robot, double times) {
  for (std::size_t p = 0; p < robot.band.parts; ++p) {
    auto& part = robot.band.part[p];
    part.to = part.from + times * (part.to - part.from);
    part.fade_to = std::max(part.fade_to, part.to);
    if (part.to > kMostExtrapolation * reach_of_model(robot.fine, part) ||
        part.to > reach_of_model(*robot.coarse, part))
      return false;
  }
  return true;
}

bool fade_by(JointSnapshot::Robot& robot, double times) {
  robot.band.anchored = true;
  bool any = false;
  for (std::size_t p = 0; p < robot.band.parts; ++p) {
    auto& part = robot.band.part[p];
    const double wanted = part.to + times * (part.to - part.from);
    // No farther than the coarse model goes: beyond it nothing asks.
    part.fade_to = std::min(wanted, std::max(part.to + 1e-9, reach_of_model(*robot.coarse, part)));
    any = any || part.fade_to == wanted;
  }
  return any;
}

std::string figure_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace

BandReport check_band(const JointSnapshot::Robot& robot, std::int64_t most_poses) {
  BandReport report = Look(robot, most_poses).report();
  if (report.accepted() || robot.band.parts == 0) return report;
  for (const double times : {1.25, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0}) {
    auto wider = robot;
    wider.band.anchored = false;
    if (!widen(wider, times)) break;
    if (!Look(wider, most_poses).accepted()) continue;
    report.wider_to = wider.band.part[0].to;
    break;
  }
  for (const double times : {1.0, 2.0, 4.0, 8.0, 16.0, 24.0, 32.0, 48.0, 64.0}) {
    auto anchored = robot;
    if (!fade_by(anchored, times)) break;
    if (!Look(anchored, most_poses).accepted()) continue;
    report.anchored_fade_to = anchored.band.part[0].fade_to;
    break;
  }
  return report;
}

std::string sentence_of(const BandReport& report) {
  std::string out = "the two models of the blend" +
                    (report.robot.empty() ? std::string() : " of robot " + report.robot) +
                    " differ by " + figure_text(report.largest_difference_nm * 1e-3) + " um of " +
                    report.largest_channel;
  if (report.difference_arcsec > 0)
    out += " (" + figure_text(report.difference_arcsec) + " arcsec)";
  std::string where;
  for (const auto& value : report.largest_at)
    where += (where.empty() ? " at " : ", ") + value.channel + " = " + figure_text(value.value);
  out += where + ": along a path through the band the rate of a motor coordinate would differ by " +
         figure_text(report.rate_share) + " of the fine model's largest, less than " +
         figure_text(kMostRateShare) + " is accepted";
  if (report.determinant_share)
    out += ", and the Jacobian's determinant would keep " + figure_text(*report.determinant_share) +
           " of its size, more than " + figure_text(kLeastDeterminantShare) + " is accepted";
  out += " (looked at " + std::to_string(report.poses) + " poses" +
         (report.whole_grid ? ")" : ", a part of the grid and the worst places found on it)");
  if (report.accepted()) return out;
  if (report.anchored_fade_to)
    out += "; accepted would be: anchored = true with fade_to = " +
           figure_text(*report.anchored_fade_to);
  if (report.wider_to)
    out += std::string(report.anchored_fade_to ? ", or" : "; accepted would be:") +
           " a wider band with to = " + figure_text(*report.wider_to);
  if (!report.anchored_fade_to && !report.wider_to)
    out +=
        "; neither anchoring nor a wider band within the models' ranges mends it: fit the coarse "
        "model better, or the fine one over a larger range";
  return out;
}

}  // namespace driftwise::plans
