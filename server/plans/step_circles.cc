#include "server/plans/step_circles.h"

#include <algorithm>
#include <cmath>

#include "server/plans/joint_target.h"

namespace driftwise::plans {
namespace {

using compensation::bit;
using compensation::Variable;

constexpr int kPlaces = 5, kGrowthPasses = 60;
// A circle whose coordinates change places has a growth that alternates: the mean over these passes
// is that of whole rounds of 2, 3, 4 and 6.
constexpr int kMeanPasses = 12;

// Largest size of the slope of each output of a step by each coordinate it reads.
using Slopes = std::array<std::array<double, compensation::kVariables>, compensation::kMaxOutputs>;

Slopes largest_slopes(const compensation::Snapshot& model) {
  std::vector<const compensation::Snapshot::Input*> by;
  for (const auto& input : model.inputs)
    if (input.variable) by.push_back(&input);
  Slopes largest{};
  std::size_t places = 1;
  for (std::size_t i = 0; i < by.size(); ++i) places *= kPlaces;
  for (std::size_t place = 0; place < places; ++place) {
    Values pose{};
    std::size_t left = place;
    for (const auto* input : by) {
      const double share = static_cast<double>(left % kPlaces) / (kPlaces - 1);
      left /= kPlaces;
      pose[static_cast<std::size_t>(*input->variable)] =
          input->min + share * (input->max - input->min);
    }
    for (const auto* input : by) {
      const auto v = static_cast<std::size_t>(*input->variable);
      std::array<double, compensation::kMaxOutputs> slope{};
      model_slopes(model, pose, *input->variable, slope.data());
      for (std::size_t i = 0; i < model.outputs.size(); ++i)
        largest[i][v] = std::max(largest[i][v], std::abs(slope[i]));
    }
  }
  return largest;
}

}  // namespace

bool StepCircles::any() const {
  return std::ranges::any_of(circle, [](std::uint32_t bits) { return bits != 0; });
}

StepCircles circles_of(const JointSnapshot& snapshot) {
  StepCircles out;
  const std::size_t count = snapshot.steps.size();
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < count; ++b) {
      const auto& from = snapshot.steps[a];
      const auto& into = snapshot.steps[b];
      if (from.to != into.from) continue;
      for (std::size_t i = 0; i < from.output.size(); ++i)
        if ((from.added >> i & 1) != 0 && (into.predicts.needed & bit(from.output[i])) != 0)
          out.after[a] |= std::uint32_t{1} << b;
    }
  auto reach = out.after;
  for (std::size_t through = 0; through < count; ++through)
    for (std::size_t a = 0; a < count; ++a)
      if ((reach[a] >> through & 1) != 0) reach[a] |= reach[through];
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < count; ++b)
      if ((reach[a] >> b & 1) != 0 && (reach[b] >> a & 1) != 0)
        out.circle[a] |= std::uint32_t{1} << b;
  return out;
}

double contraction_of(const JointSnapshot& snapshot) {
  const std::size_t count = snapshot.steps.size();
  std::vector<Slopes> slopes;
  for (const auto& step : snapshot.steps) slopes.push_back(largest_slopes(step.predicts));
  // What is wrong with each added term, by step and output: one pass after another, each step with
  // the newest of those that feed it. All slopes are positive sizes, so growth is that of the
  // worst.
  std::array<std::array<double, compensation::kMaxOutputs>, kMostSteps> wrong{};
  for (auto& step : wrong) step.fill(1);
  double log_growth = 0;
  for (int pass = 0; pass < kGrowthPasses; ++pass) {
    double before = 0, now = 0;
    for (std::size_t b = 0; b < count; ++b) {
      const auto& into = snapshot.steps[b];
      std::array<double, compensation::kVariables> moved{};
      for (std::size_t a = 0; a < count; ++a) {
        if (snapshot.steps[a].to != into.from) continue;
        for (std::size_t i = 0; i < snapshot.steps[a].output.size(); ++i)
          if ((snapshot.steps[a].added >> i & 1) != 0)
            moved[static_cast<std::size_t>(snapshot.steps[a].output[i])] += wrong[a][i];
      }
      for (std::size_t i = 0; i < into.output.size(); ++i) {
        double sum = 0;
        for (std::size_t v = 0; v < moved.size(); ++v) sum += slopes[b][i][v] * moved[v];
        if ((into.added >> i & 1) != 0) {
          before += wrong[b][i];
          now += sum;
        }
        wrong[b][i] = sum;
      }
    }
    if (!(now > 0)) return 0;  // no circle: nothing is left to settle
    if (pass >= kGrowthPasses - kMeanPasses) log_growth += std::log(now / before);
    for (auto& step : wrong)
      for (double& one : step) one /= now;
  }
  return std::exp(log_growth / kMeanPasses);
}

}  // namespace driftwise::plans
