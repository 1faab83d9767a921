#include "server/compensation/target.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "server/compensation/own_variance.h"
#include "server/compensation/snapshot_builder.h"
#include "server/formats/formula/formula.h"
#include "server/formats/model/model_json.h"
#include "tests/unit/compensation/models.h"

namespace driftwise::compensation {
namespace {

constexpr CellTime kNow{1'300'000'000'000'000'000};

class ServedAxis : public testing::Test {
 protected:
  void serve(calibration::Model model, CellDescription cell) {
    auto made = SnapshotBuilder::create(std::move(model), ModelId{3}, cell);
    ASSERT_TRUE(made) << made.error().message;
    builder = std::make_unique<SnapshotBuilder>(std::move(*made));
    builder->keep_model_datum();
  }
  void read_t07(double degc, CellTime at = kNow) {
    const ChannelValue value{"t07_degC", degc};
    builder->observe(std::span(&value, 1), at);
  }
  Target at_x(double x_mm) {
    TargetRequest request;
    request.set(Variable::x, x_mm);
    return compute_target(builder->build(kNow), request);
  }
  std::unique_ptr<SnapshotBuilder> builder;
};

TEST_F(ServedAxis, GivesTheModelsValueAtTheObservedTemperature) {
  serve(axis_model(), axis_cell());
  read_t07(21.25);
  const double x = 1.5;
  const auto target = at_x(x);
  ASSERT_EQ(target.refusal, Refusal::none);
  EXPECT_EQ(target.flags, 0u);
  ASSERT_EQ(target.outputs, 1u);
  EXPECT_NEAR(target.q_mm[0], 1 + 2 * x + 0.5 * x * x + 1e-3 * 21.25 + 2e-4 * x * 21.25, 1e-14);
}

// The oracle is the unfolded law of propagation: a' C a with a the raw terms, and (dq/dT u)^2,
// scale^2 and what of rmse^2 the scale's noise does not explain (own_variance.h).
TEST_F(ServedAxis, GivesTheUncertaintyOfTheUnfoldedModel) {
  const auto model = axis_model();
  serve(model, axis_cell());
  read_t07(21.25);
  const double x = -2.75, t = 21.25;
  Eigen::VectorXd a(5);
  a << 1, x, x * x, t, x * t;
  const double fit_nm = 1e6 * std::sqrt(a.dot(model.outputs[0].covariance * a));
  const double temperature_nm = 1e6 * std::abs(1e-3 + 2e-4 * x) * 0.002;
  const auto target = at_x(x);
  const double own_nm = std::sqrt(own_variance(8.0 * 8.0, 3.0 * 3.0, model.outputs[0].dof));
  EXPECT_NEAR(
      target.u_nm[0],
      std::sqrt(fit_nm * fit_nm + temperature_nm * temperature_nm + own_nm * own_nm + 3.0 * 3.0),
      1e-6);
  EXPECT_DOUBLE_EQ(target.expanded_nm(0), 2 * target.u_nm[0]);
  EXPECT_DOUBLE_EQ(target.u90_nm(0), 1.645 * target.u_nm[0]);

  TargetRequest request;
  request.set(Variable::x, x);
  const auto budget = compute_budget(builder->build(kNow), request, 0);
  EXPECT_NEAR(budget.u_nm, target.u_nm[0], 1e-9);
  const auto line = [&](UncertaintySource source) {
    for (std::size_t i = 0; i < budget.lines; ++i)
      if (budget.line[i].source == source) return budget.line[i].u_nm;
    return std::nan("");
  };
  EXPECT_NEAR(line(UncertaintySource::fit), fit_nm, 1e-6);
  EXPECT_NEAR(line(UncertaintySource::temperatures), temperature_nm, 1e-6);
  EXPECT_NEAR(line(UncertaintySource::residual), own_nm, 1e-9);
  EXPECT_NEAR(own_nm, std::sqrt(8.0 * 8.0 - 3.0 * 3.0), 0.05) << "100 degrees of freedom";
  EXPECT_NEAR(line(UncertaintySource::scale), 3.0, 1e-9);
}

TEST_F(ServedAxis, NeedsNoUncertaintyToGiveTheSameCoordinate) {
  serve(axis_model(), axis_cell());
  read_t07(21);
  TargetRequest request;
  request.set(Variable::x, 1);
  request.with_uncertainty = false;
  const auto target = compute_target(builder->build(kNow), request);
  EXPECT_EQ(target.q_mm[0], at_x(1).q_mm[0]);
  EXPECT_TRUE(std::isnan(target.u_nm[0]));
}

TEST_F(ServedAxis, FlagsAPoseOutsideTheDomainAndTrustsItLess) {
  serve(axis_model(), axis_cell());
  read_t07(21);
  const auto inside = at_x(4), outside = at_x(8);
  EXPECT_EQ(inside.flags, 0u);
  EXPECT_TRUE(outside.flags & kOutsideDomain);
  EXPECT_EQ(describe_flags(builder->build(kNow), outside), "OUTSIDE_DOMAIN(x_mm)");
  EXPECT_GT(outside.u_nm[0],
            3.9 * inside.u_nm[0]);  // a range further out: the documented factor is near 4
  double last = 0;
  for (double x = 4; x < 12; x += 0.25) {
    EXPECT_GE(at_x(x).u_nm[0], last) << x;
    last = at_x(x).u_nm[0];
  }
}

TEST_F(ServedAxis, CallsAWantedPoseInsideThatIsNanometresBeyondTheMeasuredOnes) {
  serve(axis_model(), axis_cell());
  read_t07(21);
  EXPECT_EQ(at_x(4.00002).flags, 0u);
}

TEST_F(ServedAxis, FlagsATemperatureOutsideTheDomain) {
  serve(axis_model(), axis_cell());
  read_t07(23);
  const auto target = at_x(0);
  EXPECT_EQ(describe_flags(builder->build(kNow), target), "OUTSIDE_DOMAIN(t07_degC)");
}

TEST_F(ServedAxis, FlagsAStaleThermometerAndKeepsItsLastValue) {
  serve(axis_model(), axis_cell());
  read_t07(21, kNow - std::chrono::seconds(61));
  const auto target = at_x(1);
  EXPECT_EQ(target.flags, static_cast<std::uint32_t>(kStaleTemperature));
  EXPECT_EQ(describe_flags(builder->build(kNow), target), "STALE_TEMPERATURE(t07_degC)");
  EXPECT_NEAR(target.q_mm[0], 1 + 2 + 0.5 + 1e-3 * 21 + 2e-4 * 21, 1e-14);
  EXPECT_GT(target.u_nm[0], 600.0);  // 2 K of range / sqrt(12), times 1200 nm/K
}

TEST_F(ServedAxis, ServesTheMiddleOfTheRangeForAThermometerNeverRead) {
  serve(axis_model(), axis_cell());
  read_t07(kMissing);
  const auto target = at_x(0);
  EXPECT_EQ(describe_flags(builder->build(kNow), target), "MISSING_TEMPERATURE(t07_degC)");
  EXPECT_NEAR(target.q_mm[0], 1 + 1e-3 * 21, 1e-14);
}

TEST_F(ServedAxis, RefusesWhatTheCellSaysShallBeRefused) {
  auto cell = axis_cell();
  cell.serving.refuse_stale = cell.serving.refuse_outside_domain = true;
  serve(axis_model(), cell);
  auto target = at_x(0);
  EXPECT_EQ(target.refusal, Refusal::stale);
  EXPECT_TRUE(std::isnan(target.q_mm[0]));
  EXPECT_EQ(refusal_error(builder->build(kNow), target).reason, "STALE");
  EXPECT_NE(refusal_error(builder->build(kNow), target).message.find("t07_degC"),
            std::string::npos);
  read_t07(21);
  EXPECT_EQ(at_x(0).refusal, Refusal::none);
  target = at_x(9);
  EXPECT_EQ(target.refusal, Refusal::outside_domain);
  EXPECT_EQ(refusal_error(builder->build(kNow), target).code, ErrorCode::out_of_range);
}

TEST_F(ServedAxis, RefusesARequestWithoutItsCoordinate) {
  serve(axis_model(), axis_cell());
  read_t07(21);
  const auto snapshot = builder->build(kNow);
  TargetRequest request;
  request.set(Variable::y, 1);
  auto target = compute_target(snapshot, request);
  EXPECT_EQ(target.refusal, Refusal::missing_coordinate);
  EXPECT_NE(refusal_error(snapshot, target).message.find("x_mm"), std::string::npos);
  request.set(Variable::x, std::numeric_limits<double>::infinity());
  target = compute_target(snapshot, request);
  EXPECT_EQ(target.refusal, Refusal::not_finite);
}

// A controller must not be told to move to infinity, whatever it asked for.
TEST_F(ServedAxis, RefusesAPoseSoFarOutThatTheModelGivesNoNumber) {
  serve(axis_model(), axis_cell());
  read_t07(21.25);
  for (const double x_mm : {1e308, -1e308, 1e160}) {
    TargetRequest request;
    request.set(Variable::x, x_mm);
    const auto snapshot = builder->build(kNow);
    const auto target = compute_target(snapshot, request);
    EXPECT_EQ(target.refusal, Refusal::outside_domain) << x_mm;
    EXPECT_TRUE(std::isnan(target.q_mm[0])) << x_mm;
    const auto error = refusal_error(snapshot, target);
    EXPECT_EQ(error.code, ErrorCode::out_of_range);
    EXPECT_EQ(error.reason, "OUTSIDE_DOMAIN");
    EXPECT_NE(error.message.find("x_mm so far outside"), std::string::npos) << error.message;
  }
  // The coordinate is a number, its uncertainty is none: without it the question can be answered.
  TargetRequest far;
  far.set(Variable::x, 1e120);
  EXPECT_EQ(compute_target(builder->build(kNow), far).refusal, Refusal::outside_domain);
  far.with_uncertainty = false;
  far.show_unreachable = true;
  EXPECT_EQ(compute_target(builder->build(kNow), far).refusal, Refusal::none);
}

TEST(ComputeTarget, RefusesWithoutAModel) {
  const Snapshot nothing;
  const auto target = compute_target(nothing, {});
  EXPECT_EQ(target.refusal, Refusal::no_model);
  EXPECT_EQ(refusal_error(nothing, target).reason, "NO_MODEL");
}

class LimitedAxis : public ServedAxis {
 protected:
  // q1(x) = 1 + 2 x + 0.5 x^2 + ... : 3.5 at x = 1, 7 at x = 2.
  void SetUp() override {
    cell.devices[0].become<MotionSettings>().axes[0].min_mm = -0.2;
    cell.devices[0].become<MotionSettings>().axes[0].max_mm = 5;
  }
  Target asked(double x_mm, bool show_unreachable) {
    TargetRequest request;
    request.set(Variable::x, x_mm);
    request.show_unreachable = show_unreachable;
    return compute_target(builder->build(kNow), request);
  }
  CellDescription cell = axis_cell();
};

TEST_F(LimitedAxis, RefusesACoordinateBeyondTheSoftLimits) {
  serve(axis_model(), cell);
  read_t07(21);
  EXPECT_EQ(asked(1, false).refusal, Refusal::none);
  const auto beyond = asked(2, false);
  EXPECT_EQ(beyond.refusal, Refusal::outside_limits);
  EXPECT_TRUE(std::isnan(beyond.q_mm[0])) << "never clamped";
  EXPECT_TRUE(std::isnan(beyond.u_nm[0]));
  const auto error = refusal_error(builder->build(kNow), beyond);
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
  EXPECT_EQ(error.reason, "OUTSIDE_LIMITS(q1)");
  EXPECT_EQ(error.message,
            "q1_mm = 7.0294 lies beyond its soft limits -0.2 .. 5 mm: the pose cannot be reached; "
            "ask for one within the travel");
}

TEST_F(LimitedAxis, ShowsTheNumbersToWhoAsksForThem) {
  serve(axis_model(), cell);
  read_t07(21);
  const auto shown = asked(2, true);
  EXPECT_EQ(shown.refusal, Refusal::none);
  EXPECT_NEAR(shown.q_mm[0], 7.0294, 1e-12) << "as computed, not clamped";
  EXPECT_EQ(describe_flags(builder->build(kNow), shown), "OUTSIDE_LIMITS(q1)");
  EXPECT_EQ(asked(1, true).flags, 0u);
}

TEST_F(LimitedAxis, OnlyFlagsWhereTheCellFileSaysSo) {
  cell.serving.refuse_outside_limits = false;
  serve(axis_model(), cell);
  read_t07(21);
  const auto flagged = asked(2, false);
  EXPECT_EQ(flagged.refusal, Refusal::none);
  EXPECT_EQ(flagged.flags, static_cast<std::uint32_t>(kOutsideLimits));
}

TEST_F(LimitedAxis, SaysThatNoLimitsAreKnown) {
  cell.devices[0].become<MotionSettings>().axes.clear();
  serve(axis_model(), cell);
  read_t07(21);
  const auto target = asked(2, false);
  EXPECT_EQ(target.refusal, Refusal::none);
  EXPECT_EQ(describe_flags(builder->build(kNow), target), "UNKNOWN_LIMITS(q1)");
}

TEST_F(ServedAxis, NamesTheCoordinatesThatTheModelDoesNotKnow) {
  serve(axis_model(), axis_cell());
  read_t07(21);
  TargetRequest request;
  request.set(Variable::x, 1);
  request.set(Variable::rx, 2);
  request.set(Variable::force, 0);
  const auto snapshot = builder->build(kNow);
  const auto target = compute_target(snapshot, request);
  EXPECT_EQ(target.refusal, Refusal::none);
  EXPECT_EQ(describe_flags(snapshot, target), "IGNORED_COORDINATE(rx_arcsec force_N)");
  EXPECT_EQ(target.q_mm[0], at_x(1).q_mm[0]);
}

TEST_F(ServedAxis, IsValidUntilTheNextRebuildOrAThermometerGrowsStale) {
  serve(axis_model(), axis_cell());
  read_t07(21);
  EXPECT_EQ(at_x(0).valid_until, kNow + std::chrono::seconds(10));
  serve(axis_model(), axis_cell());
  read_t07(21, kNow - std::chrono::seconds(56));
  EXPECT_EQ(at_x(0).valid_until, kNow + std::chrono::seconds(4));
}

TEST_F(ServedAxis, FlagsASnapshotThatNobodyRebuilt) {
  serve(axis_model(), axis_cell());
  read_t07(21);
  TargetRequest request;
  request.set(Variable::x, 0);
  request.now = kNow + std::chrono::seconds(11);
  EXPECT_EQ(compute_target(builder->build(kNow), request).flags,
            static_cast<std::uint32_t>(kExpiredConditions));
}

// An axis that is used far from its zero, in powers of it.
struct FarAxis {
  double middle_mm, half_mm, noise_nm;
  int degree;
};

struct FarFit {
  calibration::Model model;
  Eigen::MatrixXd inverse;  // of A'A, A the powers of (x - middle) / half: well conditioned
  double variance_nm2 = 0;
};

FarFit fitted_far_from_zero(const FarAxis& axis) {
  std::mt19937 random(1);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> place(-1, 1);
  Dataset data;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  data.rows = 200;
  Eigen::MatrixXd powers(200, axis.degree + 1);
  Eigen::VectorXd q(200);
  for (int i = 0; i < 200; ++i) {
    const double x = axis.middle_mm + axis.half_mm * place(random);
    const double w = (x - axis.middle_mm) / axis.half_mm;
    q[i] = (x - axis.middle_mm) * 1.0001 + 0.3 + axis.noise_nm * 1e-6 * gauss(random);
    for (int k = 0; k <= axis.degree; ++k) powers(i, k) = std::pow(w, k);
    data.time_s.push_back(30.0 * i);
    data.columns[0].values.push_back(q[i]);
    data.columns[1].values.push_back(x);
  }
  calibration::FitOptions options;
  options.select = calibration::Select::all;
  const auto model =
      formats::fit_formula(data, "q ~ poly(x, " + std::to_string(axis.degree) + ")", options);
  EXPECT_TRUE(model) << model.error().message;
  const auto read = formats::read_model_json(formats::write_model_json(*model));
  EXPECT_TRUE(read) << read.error().message;
  const Eigen::VectorXd rest = q - powers * powers.householderQr().solve(q);
  return {*read, (powers.transpose() * powers).inverse(),
          rest.squaredNorm() / (200 - axis.degree - 1) * 1e12};
}

Target target_of(const calibration::Model& model, double x, Budget* budget = nullptr) {
  auto builder = SnapshotBuilder::create(model, ModelId{1}, CellDescription{});
  EXPECT_TRUE(builder) << builder.error().message;
  builder->keep_model_datum();
  const auto snapshot = builder->build(CellTime{1'000'000'000});
  TargetRequest request;
  request.set(Variable::x, x);
  request.with_uncertainty = true;
  request.now = CellTime{1'000'000'000};
  if (budget != nullptr) *budget = compute_budget(snapshot, request, 0);
  auto target = compute_target(snapshot, request);
  if (target.refusal != Refusal::none)
    target.why = std::make_shared<const Error>(refusal_error(snapshot, target));
  return target;
}

// What is left between is the noise that the fit finds with correlation in it, not white: 2 % of u.
TEST(Target, HasTheDigitsOfItsUncertaintyFarFromZero) {
  for (const FarAxis& axis :
       {FarAxis{0, 2, 1000, 3}, FarAxis{500, 2, 1000, 3}, FarAxis{1500, 2, 1000, 3},
        FarAxis{3000, 5, 10000, 3}, FarAxis{1500, 2, 1000, 4}, FarAxis{100, 2, 100, 5}}) {
    const auto fit = fitted_far_from_zero(axis);
    for (const double w : {-0.9, -0.5, 0.0, 0.8}) {
      Eigen::VectorXd at(axis.degree + 1);
      for (int k = 0; k <= axis.degree; ++k) at[k] = std::pow(w, k);
      const double leverage = at.dot(fit.inverse * at);
      Budget budget;
      const auto target = target_of(fit.model, axis.middle_mm + axis.half_mm * w, &budget);
      const double expected_nm = std::sqrt(fit.variance_nm2 * (1 + leverage));
      EXPECT_NEAR(target.u_nm[0] / expected_nm, 1, 0.02) << axis.middle_mm << " " << w;
      EXPECT_EQ(budget.line[0].source, UncertaintySource::fit);
      EXPECT_NEAR(budget.line[0].u_nm / std::sqrt(fit.variance_nm2 * leverage), 1, 0.25)
          << axis.middle_mm << " " << w;
      EXPECT_NEAR(budget.u_nm / target.u_nm[0], 1, 1e-3);
    }
  }
}

TEST(Target, OfAModelOfBeforeWhoseVarianceComesOutNegativeIsRefused) {
  auto fit = fitted_far_from_zero({3000, 5, 10000, 3});
  fit.model.outputs[0].covariance_root.resize(0, 0);
  int refused = 0;
  for (const double x : {2995.5, 2997.5, 3000.0, 3004.0}) {
    const auto target = target_of(fit.model, x);
    if (target.refusal == Refusal::none) {
      EXPECT_GT(target.u_nm[0], 1) << x;
      continue;
    }
    ++refused;
    EXPECT_EQ(target.why->reason, "DIGITS_LOST");
    EXPECT_NE(target.why->message.find("fit it again"), std::string::npos);
  }
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace driftwise::compensation
