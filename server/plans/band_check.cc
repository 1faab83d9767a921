#include "server/plans/band_check.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/core/text/shown_text.h"
#include "server/plans/joint_target.h"

namespace driftwise::plans {
namespace {

using compensation::Snapshot;
using compensation::Variable;
using Jacobian = Eigen::MatrixXd;  // outputs by inputs, mm per request's unit

// Of the grid between from and to, and between to and fade_to.
constexpr int kAngleSteps = 16, kLengthSteps = 6;
constexpr int kDirections = 24;  // over half a turn among two angles
// What may lie between two points of the grid, and between two directions.
constexpr double kBetween = 1.05;

bool is_rotation(Variable variable) { return variable >= Variable::rx && variable <= Variable::rz; }

struct Range {
  double min = 0, max = 0;
};

Range range_of(const Snapshot& model, Variable variable) {
  for (const auto& input : model.inputs)
    if (input.variable == variable) return {input.min, input.max};
  return {};
}

std::vector<Variable> inputs_of(const JointSnapshot::Robot& robot) {
  std::vector<Variable> out;
  for (std::size_t v = 0; v < compensation::kVariables; ++v)
    if ((robot.needed >> v & 1) != 0) out.push_back(static_cast<Variable>(v));
  return out;
}

// Positions of one input on the grid.
std::vector<double> positions(const JointSnapshot::Robot& robot, Variable variable) {
  for (std::size_t p = 0; p < robot.band.parts; ++p) {
    const auto& part = robot.band.part[p];
    if (part.coordinate != variable) continue;
    std::vector<double> out = {part.centre};
    const auto add = [&](double distance) {
      if (part.side != BandSide::below) out.push_back(part.centre + distance);
      if (part.side != BandSide::above) out.push_back(part.centre - distance);
    };
    // Inside, where another coordinate may be in its own band.
    const Range inside = range_of(robot.fine, variable);
    if (part.side == BandSide::above) out.push_back(inside.min);
    if (part.side == BandSide::below) out.push_back(inside.max);
    const int steps = is_rotation(variable) ? kAngleSteps : kLengthSteps;
    for (int k = 0; k <= steps; ++k) add(part.from + (part.to - part.from) * k / steps);
    if (robot.band.anchored)
      for (int k = 1; k < steps; ++k) add(part.to + (part.fade_to - part.to) * k / steps);
    return out;
  }
  const Range fine = range_of(robot.fine, variable), coarse = range_of(*robot.coarse, variable);
  const bool in_fine = fine.min < fine.max, in_coarse = coarse.min < coarse.max;
  const Range both = in_fine && in_coarse
                         ? Range{std::max(fine.min, coarse.min), std::min(fine.max, coarse.max)}
                     : in_fine ? fine
                               : coarse;
  if (variable == Variable::force || !(both.min < both.max)) return {0.5 * (both.min + both.max)};
  return {both.min, 0.5 * (both.min + both.max), both.max};
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

class Look {
 public:
  explicit Look(const JointSnapshot::Robot& robot)
      : robot_(robot),
        inputs_(inputs_of(robot)),
        outputs_(robot.fine.outputs.size()),
        directions_(directions_of(robot, inputs_)) {
    for (const auto variable : inputs_) {
      double width = 0;
      for (std::size_t p = 0; p < robot.band.parts; ++p)
        if (robot.band.part[p].coordinate == variable)
          width = robot.band.part[p].to - robot.band.part[p].from;
      const Range range = range_of(*robot.coarse, variable);
      steps_.push_back(1e-4 * (width > 0 ? width : std::max(1e-3, range.max - range.min)));
    }
  }

  BandReport report() {
    BandReport out;
    out.robot = robot_.id;
    out.anchored = robot_.band.anchored;
    largest_rate_ = std::vector<double>(directions_.size(), 0.0);
    walk([&](const Values& pose) { see_fine(pose, out); });
    double determinant = std::numeric_limits<double>::infinity();
    walk([&](const Values& pose) { compare(pose, out, determinant); });
    if (square() && std::isfinite(determinant)) out.determinant_share = determinant;
    return out;
  }

 private:
  bool square() const { return outputs_ == inputs_.size(); }

  // Poses where two models have a say: the band, and where an anchor fades out.
  template <class Visit>
  void walk(const Visit& visit) const {
    std::vector<std::vector<double>> grid;
    for (const auto variable : inputs_) grid.push_back(positions(robot_, variable));
    std::vector<std::size_t> at(grid.size(), 0);
    for (;;) {
      Values pose{};
      for (std::size_t j = 0; j < grid.size(); ++j)
        pose[static_cast<std::size_t>(inputs_[j])] = grid[j][at[j]];
      const double w = fine_weight(robot_.band, pose), fade = anchor_fade(robot_.band, pose);
      if ((w > 0 && w < 1) || (w == 0 && fade > 0 && fade < 1)) visit(pose);
      std::size_t j = 0;
      while (j < grid.size() && ++at[j] == grid[j].size()) at[j++] = 0;
      if (j == grid.size()) return;
    }
  }

  Jacobian of_model(const Snapshot& model, const Values& pose) const {
    return jacobian_of(outputs_, inputs_, steps_, pose,
                       [&](const Values& p, double* out) { model_coordinates(model, p, out); });
  }

  void see_fine(const Values& pose, BandReport& out) {
    if (fine_weight(robot_.band, pose) <= 0) return;
    const Jacobian fine = of_model(robot_.fine, pose);
    for (std::size_t d = 0; d < directions_.size(); ++d)
      largest_rate_[d] = std::max(largest_rate_[d], (fine * directions_[d]).cwiseAbs().maxCoeff());
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
    if (nm <= out.largest_difference_nm) return;
    out.largest_difference_nm = nm;
    out.largest_channel = channel_name(robot_.id, robot_.fine.outputs[worst].channel.name());
    out.largest_at.clear();
    for (const auto variable : inputs_)
      out.largest_at.push_back(
          {channel_name(robot_.id, variable), pose[static_cast<std::size_t>(variable)]});
    out.difference_arcsec = 0;
    if (!square()) return;
    const Eigen::VectorXd moved = fine.fullPivLu().solve(apart);
    double squares = 0;
    for (std::size_t j = 0; j < inputs_.size(); ++j)
      if (is_rotation(inputs_[j]))
        squares += moved(static_cast<Eigen::Index>(j)) * moved(static_cast<Eigen::Index>(j));
    out.difference_arcsec = std::sqrt(squares);
  }

  void compare(const Values& pose, BandReport& out, double& determinant) const {
    const bool in_band = fine_weight(robot_.band, pose) > 0;
    const Jacobian reference = of_model(in_band ? robot_.fine : *robot_.coarse, pose);
    const Jacobian blended =
        jacobian_of(outputs_, inputs_, steps_, pose,
                    [&](const Values& p, double* q) { robot_coordinates(robot_, p, q); });
    const Jacobian deviation = blended - reference;
    for (std::size_t d = 0; d < directions_.size(); ++d)
      out.rate_share =
          std::max(out.rate_share, kBetween * (deviation * directions_[d]).cwiseAbs().maxCoeff() /
                                       std::max(largest_rate_[d], 1e-300));
    if (square())
      determinant = std::min(determinant, blended.determinant() / reference.determinant());
  }

  const JointSnapshot::Robot& robot_;
  std::vector<Variable> inputs_;
  std::size_t outputs_;
  std::vector<double> steps_;
  std::vector<Eigen::VectorXd> directions_;
  std::vector<double> largest_rate_;
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

BandReport check_band(const JointSnapshot::Robot& robot) {
  BandReport report = Look(robot).report();
  if (report.accepted() || robot.band.parts == 0) return report;
  for (const double times : {1.25, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0}) {
    auto wider = robot;
    wider.band.anchored = false;
    if (!widen(wider, times)) break;
    if (!Look(wider).report().accepted()) continue;
    report.wider_to = wider.band.part[0].to;
    break;
  }
  for (const double times : {1.0, 2.0, 4.0, 8.0, 16.0, 24.0, 32.0, 48.0, 64.0}) {
    auto anchored = robot;
    if (!fade_by(anchored, times)) break;
    if (!Look(anchored).report().accepted()) continue;
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
