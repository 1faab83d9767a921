#include "tests/hidden_effects/foreign/generate.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tests/hidden_effects/foreign/strength.h"

namespace driftwise::foreign {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kAttempts = 40;
// Difference in 2 ln L above which a rival is told apart (statistical contract).
constexpr double kTellApart = 20.0;
// Raw size of an effect in noise standard deviations, rms, above which the draw is refused.
constexpr double kLargestRaw = 120.0;
// Share of an unlisted effect that one catalogue entry may explain.
constexpr double kLargestExplained = 0.4;

std::string drawn_variation(const Order& order, Random& random) {
  if (order.vary != "cycle") {
    return order.vary;
  }
  static const std::vector<std::string> single{"robot", "plan", "noise", "sensors", "units"};
  const std::string one = random.pick(single);
  return random.chance(0.7) ? "all" : one;
}

Needs joined(const Needs& a, const Needs& b) {
  Needs out;
  out.thermometers = std::max(a.thermometers, b.thermometers);
  out.spare = std::max(a.spare, b.spare);
  out.force = a.force || b.force;
  out.force_left_out = a.force_left_out || b.force_left_out;
  out.activity = a.activity || b.activity;
  out.tilts = a.tilts || b.tilts;
  out.air = a.air || b.air;
  out.times = a.times || b.times;
  out.unsensed_heat = a.unsensed_heat || b.unsensed_heat;
  out.degree = std::min(a.degree, b.degree);
  if (out.spare > 0) {
    out.thermometers = std::max(out.thermometers, 3);
  }
  return out;
}

bool fit_together(const std::string& a, const std::string& b) {
  const Needs first = cause_needs(a);
  const Needs second = cause_needs(b);
  const bool forces =
      (first.force && second.force_left_out) || (first.force_left_out && second.force);
  return a != b && !forces;
}

std::vector<std::string> drawn_causes(const Order& order, Random& random) {
  if (order.kind == "null") {
    return {};
  }
  if (order.kind == "unlisted") {
    return {order.cause.empty() ? unlisted_ids()[order.seed % unlisted_ids().size()] : order.cause};
  }
  const std::string first =
      order.cause.empty() ? cause_ids()[order.seed % cause_ids().size()] : order.cause;
  if (order.kind == "single") {
    return {first};
  }
  std::string second = random.pick(cause_ids());
  while (!fit_together(first, second)) {
    second = random.pick(cause_ids());
  }
  return {first, second};
}

// Effect of one mechanism alone, and the readings that the baseline is then given.
struct Alone {
  MatrixXd effect;
  MatrixXd read;
};

Alone alone(const Campaign& campaign, const Errors& errors) {
  const MatrixXd none = campaign.no_motor_error();
  const MatrixXd clean = campaign.pose(none, none, campaign.read);
  if (errors.read.size() > 0) {
    return {campaign.effect(clean, campaign.pose(none, none, errors.read)), errors.read};
  }
  return {campaign.effect(campaign.pose(errors.dq, errors.dp, campaign.read), clean),
          campaign.read};
}

// Ratio of spreads at which a change of spread has the wanted 2 ln L.
double spread_ratio(const Campaign& campaign, int from_row, double wanted) {
  double before = 0.0;
  double after = 0.0;
  for (const int i : campaign.calibration) {
    (i < from_row ? before : after) += 1.0;
  }
  const auto likelihood = [&](double ratio) {
    const double mean = (before + after * ratio * ratio) / (before + after);
    return (before + after) * std::log(mean) - after * 2.0 * std::log(ratio);
  };
  double low = 1.0;
  double high = 20.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (likelihood(middle) < wanted ? low : high) = middle;
  }
  return low;
}

double scaled_amplitude(const Campaign& campaign, const Hidden& hidden, double wanted) {
  double amplitude = hidden.start;
  double chi2 = 0.0;
  for (int step = 0; step < 12; ++step) {
    const Alone made = alone(campaign, hidden.errors(amplitude));
    const Whitened whitened(campaign, made.read);
    chi2 = whitened.chi2(made.effect);
    if (!(chi2 > 1e-12)) {
      throw std::runtime_error("nothing is left beyond the baseline");
    }
    const MatrixXd raw = made.effect * campaign.robot.sigma.cwiseInverse().asDiagonal();
    if (std::abs(chi2 / wanted - 1.0) < 0.01) {
      if (std::sqrt(raw.squaredNorm() / campaign.rows()) > kLargestRaw) {
        throw std::runtime_error("nearly wholly in the span of the baseline");
      }
      return amplitude;
    }
    amplitude *= std::clamp(std::sqrt(wanted / chi2), 0.05, 20.0);
    if (amplitude > hidden.largest) {
      throw std::runtime_error("larger than a machine has");
    }
  }
  throw std::runtime_error("the wanted strength was not reached");
}

void judge_identifiability(const Campaign& campaign, Truth& truth, const Whitened& whitened,
                           const MatrixXd& effect, const MatrixXd& beside) {
  truth.subjects = {truth.subject};
  const std::vector<Rival> rivals = rivals_of(campaign, whitened, effect, beside);
  for (const Rival& rival : rivals) {
    // Both go with the direction of approach; a touching instrument would have to be declared.
    if (truth.cause == "backlash" && rival.cause == "probe_hysteresis") {
      continue;
    }
    if (rival.cause != truth.cause) {
      if (rival.gap <= kTellApart) {
        truth.set.push_back(rival);
      }
      if (truth.nearest.empty()) {
        truth.nearest.push_back(rival);
      }
    } else if (rival.gap <= kTellApart && rival.subject != truth.subject) {
      truth.subjects.push_back(rival.subject);
    }
  }
  truth.identifiable = truth.set.empty();
}

void add_noise(Generated& made, const std::vector<Hidden>& hidden,
               const std::vector<double>& amplitudes, Random& random) {
  const Campaign& campaign = made.campaign;
  const Noise& noise = campaign.noise;
  const double analogue = 1.0 / std::sqrt(1.0 + noise.quantum * noise.quantum / 12.0);
  for (int j = 0; j < campaign.robot.axes; ++j) {
    VectorXd series = analogue * noise.draw(campaign.time_s, random);
    for (std::size_t k = 0; k < hidden.size(); ++k) {
      if (hidden[k].noise_from_row >= 0 && hidden[k].noise_axis == j) {
        series.tail(campaign.rows() - hidden[k].noise_from_row) *= amplitudes[k];
      }
    }
    made.pose.col(j) += campaign.robot.sigma[j] * series;
    if (noise.quantum > 0.0) {
      const double step = noise.quantum * analogue * campaign.robot.sigma[j];
      made.pose.col(j) = (made.pose.col(j).array() / step).round() * step;
    }
  }
  if (campaign.has_tilts) {
    made.tilt_read = campaign.tilt;
    for (int i = 0; i < campaign.rows(); ++i) {
      for (int k = 0; k < 3; ++k) {
        made.tilt_read(i, k) += 0.02 * random.normal();
      }
    }
  }
}

Generated attempt(const Order& order, int number) {
  const std::string tag = "#" + std::to_string(number);
  Random plan_of_attempt(order.seed, "stratum");
  Random random(order.seed, "campaign" + tag);
  Random effects(order.seed, "effects" + tag);
  Generated made;
  made.order = order;
  made.attempts = number + 1;
  made.varied = drawn_variation(order, plan_of_attempt);

  const std::vector<std::string> causes = drawn_causes(order, effects);
  Needs needs;
  for (const std::string& cause : causes) {
    needs = joined(needs, order.kind == "unlisted" ? unlisted_needs(cause) : cause_needs(cause));
  }
  const bool all = made.varied == "all";
  CampaignChoice choice{order.robot,
                        order.plan,
                        order.noise,
                        order.reserved,
                        {all || made.varied == "robot", all || made.varied == "plan",
                         all || made.varied == "noise", all || made.varied == "sensors"}};
  if (order.reserved) {
    choice.vary.robot = choice.vary.plan = true;
  }
  made.campaign = make_campaign(choice, needs, random);
  const Campaign& campaign = made.campaign;
  if (campaign.noise.kind == "heteroscedastic" || campaign.noise.kind == "day_night") {
    made.allowed.push_back("noise_change");
  }

  std::vector<Hidden> hidden;
  std::vector<double> amplitudes;
  std::vector<MatrixXd> effect;
  MatrixXd dq = campaign.no_motor_error();
  MatrixXd dp = campaign.no_pose_error();
  made.read = campaign.read;
  made.error_at_zero = VectorXd::Zero(campaign.robot.axes);
  for (const std::string& cause : causes) {
    const Random before = effects;
    Hidden one = order.kind == "unlisted" ? draw_unlisted(cause, campaign, effects)
                                          : draw_cause(cause, campaign, effects);
    const double amplitude = one.noise_from_row >= 0
                                 ? spread_ratio(campaign, one.noise_from_row, order.chi2)
                                 : scaled_amplitude(campaign, one, order.chi2);
    const Errors errors = one.errors(amplitude);
    dq += errors.dq;
    dp += errors.dp;
    if (errors.read.size() > 0) {
      made.read = errors.read;
    }
    if (one.at_zero.size() > 0) {
      made.error_at_zero += amplitude * one.at_zero;
    }
    effect.push_back(alone(campaign, errors).effect);
    if (order.kind != "unlisted") {
      made.planted.push_back({cause, before, amplitude, effect.back()});
    }
    amplitudes.push_back(amplitude);
    one.parameters[one.amplitude_name] = amplitude;
    hidden.push_back(std::move(one));
  }

  const Whitened whitened(campaign, made.read);
  for (std::size_t k = 0; k < hidden.size(); ++k) {
    Truth truth;
    truth.cause = hidden[k].cause;
    truth.subject = hidden[k].subject;
    truth.parameters = hidden[k].parameters;
    truth.subjects = {truth.subject};
    const bool spread = hidden[k].noise_from_row >= 0;
    truth.chi2 = truth.chi2_beyond_other = spread ? order.chi2 : whitened.chi2(effect[k]);
    const MatrixXd beside = hidden.size() > 1 ? effect[1 - k] : MatrixXd();
    if (beside.size() > 0 && !spread) {
      const MatrixXd v = whitened.clear(effect[k]);
      const MatrixXd w = whitened.clear(beside);
      for (Eigen::Index j = 0; j < v.cols(); ++j) {
        const double size = w.col(j).squaredNorm();
        truth.chi2_beyond_other -= size > 0.0 ? std::pow(v.col(j).dot(w.col(j)), 2) / size : 0.0;
      }
      if (truth.chi2_beyond_other < 0.6 * order.chi2) {
        throw std::runtime_error("the two mechanisms cover one another");
      }
    }
    if (!spread && truth.cause != "outliers") {
      judge_identifiability(campaign, truth, whitened, effect[k], beside);
      if (order.kind == "unlisted" && !truth.nearest.empty() &&
          truth.nearest.front().gap < (1.0 - kLargestExplained) * truth.chi2) {
        throw std::runtime_error("a catalogue entry describes it here");
      }
    }
    made.truths.push_back(truth);
  }

  made.effect = MatrixXd::Zero(campaign.rows(), campaign.robot.axes);
  for (const MatrixXd& one : effect) {
    made.effect += one;
  }
  made.pose = campaign.pose(dq, dp, campaign.body);
  made.true_pose = campaign.pose(dq, campaign.no_pose_error(), campaign.body);
  made.instrument_error = dp;
  if (!(campaign.largest_gap(made.true_pose, campaign.acting_motors(dq, campaign.body)) < 1e-12)) {
    throw std::runtime_error("a pose is no root of the geometry");
  }
  Random noise(order.seed, "noise" + tag);
  add_noise(made, hidden, amplitudes, noise);
  const MatrixXd none = campaign.no_motor_error();
  made.error = campaign.effect(made.pose, campaign.pose(none, none, made.read));
  for (std::size_t k = 0; k < made.planted.size(); ++k) {
    Truth& truth = made.truths[k];
    const Carried carried =
        carried_by_readings(campaign, made.planted[k], made.read, made.tilt_read);
    const bool spread = hidden[k].noise_from_row >= 0;
    truth.chi2_in_readings = spread ? truth.chi2 : carried.in_readings;
    truth.chi2_in_smoothed_readings = spread ? truth.chi2 : carried.in_smoothed_readings;
  }
  return made;
}

}  // namespace

Generated generate(const Order& order) {
  std::string last;
  for (int number = 0; number < kAttempts; ++number) {
    try {
      return attempt(order, number);
    } catch (const std::runtime_error& error) {
      last = error.what();
    }
  }
  throw std::runtime_error("seed " + std::to_string(order.seed) + ", " + order.kind + " " +
                           order.cause + ": no draw of " + std::to_string(kAttempts) +
                           " serves, last: " + last);
}

VectorXd held_out_rms(const Campaign& campaign, const MatrixXd& read, const MatrixXd& error) {
  const MatrixXd design = campaign.design(read);
  const auto rows_of = [](const MatrixXd& table, const std::vector<int>& rows) {
    MatrixXd out(static_cast<Eigen::Index>(rows.size()), table.cols());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      out.row(static_cast<Eigen::Index>(i)) = table.row(rows[i]);
    }
    return out;
  };
  if (campaign.validation.empty()) {
    return {};
  }
  const MatrixXd fit = rows_of(design, campaign.calibration)
                           .completeOrthogonalDecomposition()
                           .solve(rows_of(error, campaign.calibration));
  const MatrixXd left =
      rows_of(error, campaign.validation) - rows_of(design, campaign.validation) * fit;
  return (left.colwise().squaredNorm() / static_cast<double>(left.rows())).cwiseSqrt().transpose();
}

}  // namespace driftwise::foreign
