#include "server/compensation/snapshot_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/compensation/model_budget.h"
#include "server/compensation/own_variance.h"
#include "server/compensation/target.h"
#include "tests/unit/compensation/models.h"

namespace driftwise::compensation {
namespace {

constexpr CellTime kBuiltAt{1'300'000'000'000'000'000};

SnapshotBuilder builder_of(const calibration::Model& model,
                           const CellDescription& cell = axis_cell()) {
  auto made = SnapshotBuilder::create(model, ModelId{1}, cell);
  EXPECT_TRUE(made) << made.error().message;
  return std::move(*made);
}

Target target_at(const SnapshotBuilder& builder, double x_mm, CellTime now = kBuiltAt) {
  TargetRequest request;
  request.set(Variable::x, x_mm);
  return compute_target(builder.build(now), request);
}

void observe(SnapshotBuilder& builder, double t07_degc, CellTime at = kBuiltAt) {
  const ChannelValue value{"t07_degC", t07_degc};
  builder.observe(std::span(&value, 1), at);
}

TEST(SnapshotBuilder, CarriesTheModelToTheZeroOfAnotherDatum) {
  auto builder = builder_of(axis_model());
  const std::vector<ChannelValue> zero = {{"q1_mm", 0.0125}, {"t07_degC", 20.5}};
  ASSERT_TRUE(builder.anchor(zero));
  observe(builder, 20.5);
  EXPECT_NEAR(target_at(builder, 0).q_mm[0], 0.0125, 1e-15);  // at the zero itself, by definition
  observe(builder, 21.5);
  EXPECT_NEAR(target_at(builder, 2).q_mm[0],
              0.0125 + 2 * 2 + 0.5 * 4 + 1e-3 * (21.5 - 20.5) + 2e-4 * 2 * 21.5, 1e-14);
  EXPECT_EQ(target_at(builder, 2).flags, 0u);
}

// The robot has warmed and stands 20 um from where pose 0 was in the model's data: the instruments
// were zeroed there, and the curve goes on from there.
TEST(SnapshotBuilder, FindsWhereTheZeroOfAnotherDatumLiesInItsOwn) {
  auto builder = builder_of(axis_model());
  const auto f = [](double x, double t) {
    return 1.0 + 2 * x + 0.5 * x * x + 1e-3 * t + 2e-4 * x * t;
  };
  ASSERT_TRUE(
      builder.anchor(std::vector<ChannelValue>{{"q1_mm", f(0.02, 20.5)}, {"t07_degC", 20.5}}));
  observe(builder, 20.5);
  EXPECT_NEAR(target_at(builder, 0).q_mm[0], f(0.02, 20.5), 1e-12);
  observe(builder, 21.5);
  EXPECT_NEAR(target_at(builder, 2).q_mm[0], f(2.02, 21.5), 1e-12);
  builder.keep_model_datum();
  EXPECT_NEAR(target_at(builder, 2).q_mm[0], f(2, 21.5), 1e-12);
}

// Two motors under one model: the pose at the zero is that of all of them together.
TEST(SnapshotBuilder, FindsTheZeroOfSeveralAxes) {
  calibration::Model model;
  const double slope[2][2] = {{1.2, 0.4}, {-0.3, 0.9}}, bend[2] = {0.01, -0.02};
  for (int i = 0; i < 2; ++i) {
    calibration::OutputModel q;
    q.channel = {"q" + std::to_string(i + 1), "mm"};
    q.terms = {term({}), term({power("x")}), term({power("y")}), term({power("x"), power("y")})};
    q.coefficients.resize(4);
    q.coefficients << 0.5, slope[i][0], slope[i][1], bend[i];
    q.covariance = Eigen::MatrixXd::Identity(4, 4) * 1e-12;
    q.dof = 100;
    q.accuracy.rmse = 8e-6;
    model.outputs.push_back(q);
  }
  model.domain = {{{"x", "mm"}, -2, 2}, {{"y", "mm"}, -2, 2}};
  const auto f = [&](int i, double x, double y) {
    return 0.5 + slope[i][0] * x + slope[i][1] * y + bend[i] * x * y;
  };
  auto builder = builder_of(model);
  ASSERT_TRUE(builder.anchor(
      std::vector<ChannelValue>{{"q1_mm", f(0, 0.01, -0.03)}, {"q2_mm", f(1, 0.01, -0.03)}}));
  TargetRequest request;
  request.set(Variable::x, 1.5);
  request.set(Variable::y, -1);
  const auto target = compute_target(builder.build(kBuiltAt), request);
  for (int i = 0; i < 2; ++i)
    EXPECT_NEAR(target.q_mm[static_cast<std::size_t>(i)], f(i, 1.51, -1.03), 1e-12);
}

// Oracle: a' C a with a = terms(pose, now) - terms(0, then), and the thermometer's own error in the
// difference only.
TEST(SnapshotBuilder, GivesAnAnchoredTargetTheUncertaintyOfTheDifference) {
  const auto model = axis_model();
  auto builder = builder_of(model);
  ASSERT_TRUE(builder.anchor(std::vector<ChannelValue>{{"q1_mm", 0.0}, {"t07_degC", 20.5}}));
  observe(builder, 21.5);
  const double x = 2, t = 21.5;
  Eigen::VectorXd a(5);
  a << 0, x, x * x, t - 20.5, x * t;
  const double fit_nm = 1e6 * std::sqrt(a.dot(model.outputs[0].covariance * a));
  const double temperature_nm = 1e6 * 2e-4 * x * 0.002;  // the slope 1e-3 is the same then and now
  const double own_nm2 = own_variance(8.0 * 8.0, 3.0 * 3.0, model.outputs[0].dof);
  EXPECT_NEAR(
      target_at(builder, x).u_nm[0],
      std::sqrt(fit_nm * fit_nm + temperature_nm * temperature_nm + 2 * (own_nm2 + 3.0 * 3.0)),
      1e-6);
}

// A target at x = 2 mm, its datum's zero taken at one temperature and asked for at another.
struct Served {
  Snapshot snapshot;
  TargetRequest request;
  Target target;
};

Served served(SnapshotBuilder builder, double zero_degC, double now_degC) {
  EXPECT_TRUE(builder.anchor(std::vector<ChannelValue>{{"q1_mm", 0.0}, {"t07_degC", zero_degC}}));
  observe(builder, now_degC);
  Served result{builder.build(kBuiltAt), {}, {}};
  result.request.set(Variable::x, 2);
  result.target = compute_target(result.snapshot, result.request);
  return result;
}

// Domain 20 .. 22 degC and half a percent: the zero at 24 lies 1.99 / 1.01 half widths outside.
TEST(SnapshotBuilder, JudgesTheConditionsOfTheZeroAsThoseOfNow) {
  const auto [snapshot, request, target] = served(builder_of(axis_model()), 24, 21);
  EXPECT_EQ(target.flags, static_cast<std::uint32_t>(kZeroOutsideDomain));
  EXPECT_EQ(describe_flags(snapshot, target), "ZERO_OUTSIDE_DOMAIN(t07_degC)");

  const double factor = std::pow(1 + 1.99 / 1.01, 2);
  const auto budget = compute_budget(snapshot, request, 0);
  double inside_nm2 = 0;
  for (std::size_t i = 0; i + 1 < budget.lines; ++i)
    inside_nm2 += budget.line[i].u_nm * budget.line[i].u_nm;
  ASSERT_EQ(budget.line[budget.lines - 1].source, UncertaintySource::extrapolation);
  EXPECT_NEAR(budget.line[budget.lines - 1].u_nm, std::sqrt(inside_nm2 * (factor * factor - 1)),
              1e-6);
  EXPECT_NEAR(target.u_nm[0], std::sqrt(inside_nm2) * factor, 1e-6);
  EXPECT_NEAR(budget.u_nm, target.u_nm[0], 1e-6);
}

// The worse end counts: both are ends of one difference.
TEST(SnapshotBuilder, TakesTheLargerExcessOfZeroAndPose) {
  const auto [snapshot, request, target] = served(builder_of(axis_model()), 23, 25);
  EXPECT_NEAR(snapshot.zero_excess, 0.99 / 1.01, 1e-12);
  EXPECT_NEAR(snapshot.slow_excess, 2.99 / 1.01, 1e-12);
  EXPECT_EQ(describe_flags(snapshot, target),
            "OUTSIDE_DOMAIN(t07_degC),ZERO_OUTSIDE_DOMAIN(t07_degC)");
  auto of_now = snapshot;
  of_now.zero_excess = 0;
  EXPECT_EQ(target.u_nm[0], compute_target(of_now, request).u_nm[0]);
}

TEST(SnapshotBuilder, JudgesPoseZeroAsAPoseWhereTheDatumIsCarried) {
  auto model = axis_model();
  model.domain[0] = {{"x", "mm"}, 1, 4};
  auto builder = builder_of(model);
  observe(builder, 21);
  builder.keep_model_datum();
  EXPECT_EQ(target_at(builder, 2).flags, 0u);  // its constant is the fitted one
  ASSERT_TRUE(builder.anchor(std::vector<ChannelValue>{{"q1_mm", 1.02}, {"t07_degC", 21.0}}));
  const auto snapshot = builder.build(kBuiltAt);
  TargetRequest request;
  request.set(Variable::x, 2);
  EXPECT_EQ(describe_flags(snapshot, compute_target(snapshot, request)),
            "ZERO_OUTSIDE_DOMAIN(x_mm)");
}

TEST(SnapshotBuilder, RefusesTargetsOfAZeroOutsideWhereTheCellRefusesThem) {
  auto cell = axis_cell();
  cell.serving.refuse_outside_domain = true;
  const auto [snapshot, request, target] = served(builder_of(axis_model(), cell), 24, 21);
  ASSERT_EQ(target.refusal, Refusal::outside_domain);
  const auto error = refusal_error(snapshot, target);
  EXPECT_EQ(error.reason, "OUTSIDE_DOMAIN");
  EXPECT_EQ(error.message.find("the zero of the present datum was taken with t07_degC outside"), 0u)
      << error.message;
}

TEST(SnapshotBuilder, FlagsADatumThatIsNotKnown) {
  auto builder = builder_of(axis_model());
  observe(builder, 21);
  EXPECT_EQ(target_at(builder, 0).flags, static_cast<std::uint32_t>(kUnanchoredDatum));
}

TEST(SnapshotBuilder, NamesWhatADatumLacks) {
  auto builder = builder_of(axis_model());
  observe(builder, 21);
  const auto anchored =
      builder.anchor(std::vector<ChannelValue>{{"q1_mm", 0.0}, {"t07_degC", kMissing}});
  ASSERT_FALSE(anchored);
  EXPECT_EQ(anchored.error().reason, "INCOMPLETE_DATUM");
  EXPECT_NE(anchored.error().message.find("t07_degC"), std::string::npos);
  EXPECT_EQ(target_at(builder, 0).flags, static_cast<std::uint32_t>(kUnanchoredDatum));
}

TEST(SnapshotBuilder, CountsFromNoEarlierZeroAfterADatumThatLacksAChannel) {
  auto builder = builder_of(axis_model());
  observe(builder, 21);
  const auto unanchored = target_at(builder, 1);
  const std::vector<ChannelValue> whole = {{"q1_mm", 0.0125}, {"t07_degC", 20.5}};
  const std::vector<ChannelValue> incomplete = {{"q1_mm", 0.0135}};
  for (const bool own : {false, true}) {
    if (own)
      builder.keep_model_datum();
    else
      ASSERT_TRUE(builder.anchor(whole));
    EXPECT_EQ(target_at(builder, 1).flags, 0u);
    EXPECT_EQ(builder.anchor(incomplete).error().reason, "INCOMPLETE_DATUM");
    const auto target = target_at(builder, 1);
    EXPECT_EQ(target.flags, static_cast<std::uint32_t>(kUnanchoredDatum)) << own;
    EXPECT_EQ(target.q_mm[0], unanchored.q_mm[0]) << own;
    EXPECT_EQ(target.u_nm[0], unanchored.u_nm[0]) << own;
  }
}

TEST(SnapshotBuilder, NeverServesTheConstantOfAnotherDatum) {
  auto model = axis_model();
  auto& q1 = model.outputs[0];
  q1.terms.push_back({{effects::Call{"datum", {}, {{2, ""}}}}});
  q1.coefficients.conservativeResize(6);
  q1.coefficients[5] = 1e6;
  q1.covariance.conservativeResizeLike(Eigen::MatrixXd::Identity(6, 6));
  auto with = builder_of(model), without = builder_of(axis_model());
  observe(with, 21), observe(without, 21);
  EXPECT_EQ(target_at(with, 1).q_mm[0], target_at(without, 1).q_mm[0]);
  EXPECT_EQ(target_at(with, 1).u_nm[0], target_at(without, 1).u_nm[0]);
}

// Powers and products over several variables, against the terms multiplied out one by one.
TEST(SnapshotBuilder, FoldsAnyProductOfPoseForceAndTemperatures) {
  calibration::Model model;
  calibration::OutputModel q2;
  q2.channel = {"q2", "um"};
  q2.terms = {term({}),
              term({power("x", 3)}),
              term({power("x"), power("y", 2), power("rz")}),
              term({power("force", 2), power("t05")}),
              term({power("t05", 2), power("pressure")}),
              term({power("x"), power("t05", 3)})};
  q2.coefficients = Eigen::VectorXd::LinSpaced(6, -1.0, 2.0);
  q2.covariance = Eigen::MatrixXd::Zero(6, 6);
  model.outputs = {q2};
  model.domain = {{{"x", "um"}, -9e3, 9e3}, {{"y", "mm"}, -9, 9},    {{"rz", "arcsec"}, -9, 9},
                  {{"force", "N"}, 0, 9},   {{"t05", "degC"}, 0, 9}, {{"pressure", "hPa"}, 0, 9}};
  auto builder = builder_of(model);
  builder.keep_model_datum();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.1, 2.0);
  for (int i = 0; i < 50; ++i) {
    const double x = uniform(random), y = uniform(random), rz = uniform(random),
                 f = uniform(random), t = uniform(random), p = uniform(random);
    const std::vector<ChannelValue> values = {{"t05_degC", t}, {"pressure_hPa", p}, {"other_V", 1}};
    builder.observe(values, kBuiltAt);
    TargetRequest request;
    request.set(Variable::x, x), request.set(Variable::y, y), request.set(Variable::rz, rz),
        request.set(Variable::force, f);
    const double x_um = 1e3 * x;
    const auto& c = q2.coefficients;
    const double q_um = c[0] + c[1] * x_um * x_um * x_um + c[2] * x_um * y * y * rz +
                        c[3] * f * f * t + c[4] * t * t * p + c[5] * x_um * t * t * t;
    const auto target = compute_target(builder.build(kBuiltAt), request);
    EXPECT_EQ(target.flags, kUnknownLimits) << "the cell has no axis q2";
    EXPECT_NEAR(target.q_mm[0], 1e-3 * q_um, 1e-12 * std::abs(q_um));
  }
}

TEST(SnapshotBuilder, FollowsAnEffectWithMemoryThroughObservedReadingsOnly) {
  auto model = axis_model();
  model.outputs[0].terms[3] = {{effects::Call{"lag", {"t07"}, {{600, "s"}}}}};
  auto builder = builder_of(model);
  builder.keep_model_datum();
  const auto lagged = [&](CellTime now) {
    return (target_at(builder, 0, now).q_mm[0] - 1.0) / 1e-3;
  };
  observe(builder, 20);
  EXPECT_NEAR(lagged(kBuiltAt), 20, 1e-9);
  observe(builder, 21, kBuiltAt + std::chrono::seconds(1));
  const auto later = kBuiltAt + std::chrono::seconds(601);
  observe(builder, 21, later);
  EXPECT_NEAR(lagged(later), 21 - std::exp(-1.0), 2e-3);  // one time constant after a step of 1 K
  const double once = lagged(later);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(lagged(later), once);  // asking advances nothing
}

// A model that follows a temperature through a lag knows no more of a thermometer that went silent.
TEST(SnapshotBuilder, AThermometerThatFellSilentIsAsUncertainBehindALag) {
  const auto u_nm = [](const effects::Term& temperature, double age_s) {
    auto model = axis_model();
    model.outputs[0].terms[3] = temperature;
    auto builder = builder_of(model);
    builder.keep_model_datum();
    if (age_s >= 0) {
      const auto newest = kBuiltAt - nanoseconds_from_s(age_s);
      observe(builder, 21,
              newest - std::chrono::hours(10));  // 60 time constants: its past is known
      observe(builder, 21, newest);
    }
    TargetRequest request;
    request.set(Variable::x, 0);
    const auto budget = compute_budget(builder.build(kBuiltAt), request, 0);
    for (std::size_t i = 0; i < budget.lines; ++i)
      if (budget.line[i].source == UncertaintySource::temperatures) return budget.line[i].u_nm;
    return 0.0;
  };
  const auto plain = term({power("t07")});
  const effects::Term lagged = {{effects::Call{"lag", {"t07"}, {{600, "s"}}}}};
  const effects::Term lagged_square = {{effects::Call{"lag", {"t07"}, {{600, "s"}}}, power("t07")}};
  // 1 um/K over a fitted range of 2 K, which counts a hundredth wider: half of it over the root
  // of 3.
  for (const double age_s : {36000.0, -1.0}) {
    EXPECT_NEAR(u_nm(plain, age_s), 1e3 * 2 / std::sqrt(12.0), 10);
    EXPECT_NEAR(u_nm(lagged, age_s), u_nm(plain, age_s), 1e-6);
    EXPECT_NEAR(u_nm(lagged_square, age_s), 2 * 21 * u_nm(plain, age_s), 1e-3);
  }
  EXPECT_NEAR(u_nm(lagged, 0), u_nm(plain, 0), 1e-6);  // the certificate's error, both
}

// q1 = x + 1 um/K behind a lag.
calibration::Model lagging_model(double tau_s) {
  auto model = axis_model();
  auto& q1 = model.outputs[0];
  q1.terms = {term({}), term({power("x")}), {{effects::Call{"lag", {"t07"}, {{tau_s, "s"}}}}}};
  q1.coefficients.resize(3);
  q1.coefficients << 0, 1, 1e-3;
  q1.covariance = Eigen::MatrixXd::Identity(3, 3) * 1e-16;
  return model;
}

CellTime hours_from_zero(double hours) { return kBuiltAt + nanoseconds_from_s(hours * 3600); }

// The room rises by 0.5 K/h from the zero on.
void observe_ramp(SnapshotBuilder& builder, double from_h, double to_h) {
  for (double h = from_h; h <= to_h + 1e-9; h += 1.0 / 360)
    observe(builder, 20.5 + 0.5 * std::max(0.0, h), hours_from_zero(h));
}

const std::vector<ChannelValue> kZeroOfRamp = {{"q1_mm", 0.0}, {"t07_degC", 20.5}};

TEST(SnapshotBuilder, IsAnchoredByAnotherThatSawTheReadingsUpToTheZero) {
  const auto model = lagging_model(3600);
  auto at_zero = builder_of(model), now = builder_of(model);
  observe_ramp(at_zero, -10, 0);
  ASSERT_TRUE(at_zero.anchor(kZeroOfRamp));
  observe_ramp(now, -10, 3);
  now.keep_anchor_of(at_zero);
  const auto target = target_at(now, 1, hours_from_zero(3));
  EXPECT_EQ(target.flags, 0u);
  const double lagged = 0.5 * (3 - (1 - std::exp(-3.0)));  // of a ramp, by hand
  EXPECT_NEAR(target.q_mm[0], 1 + 1e-3 * lagged, 1e-7 * lagged);
}

TEST(SnapshotBuilder, SaysThatReadingsBeginAfterTheZeroOfADatum) {
  auto builder = builder_of(lagging_model(3600));
  const auto anchored = builder.anchor(kZeroOfRamp);
  ASSERT_FALSE(anchored);
  EXPECT_EQ(anchored.error().reason, "INCOMPLETE_DATUM");
  EXPECT_NE(anchored.error().message.find("begin after the zero"), std::string::npos)
      << anchored.error().message;
}

TEST(SnapshotBuilder, NeedsReadingsOfTenTimeConstants) {
  EXPECT_EQ(builder_of(axis_model()).memory(), Nanoseconds(0));
  EXPECT_EQ(builder_of(lagging_model(43200)).memory(), std::chrono::hours(120));
}

double temperatures_nm(const SnapshotBuilder& builder, CellTime now) {
  TargetRequest request;
  request.set(Variable::x, 1);
  const auto budget = compute_budget(builder.build(now), request, 0);
  for (std::size_t i = 0; i < budget.lines; ++i)
    if (budget.line[i].source == UncertaintySource::temperatures) return budget.line[i].u_nm;
  return 0;
}

void observe_constant(SnapshotBuilder& builder, double from_h, double to_h) {
  constexpr int kReadings = 4000;
  for (int i = 0; i <= kReadings; ++i)
    observe(builder, 21, hours_from_zero(from_h + (to_h - from_h) * i / kReadings));
}

// The thermometer was somewhere in its fitted range of 2 K (a hundredth wider) before its first
// reading, and 1 um/K of that dies away with the time constant.
constexpr double kUnknownPast_nm = 1e3 * 2 * 1.01 / 3.4641016;
constexpr double kCertificate_nm = 1e3 * 0.002;

TEST(SnapshotBuilder, AMemoryThatBeganLatelyIsUncertainByTheFittedRange) {
  for (const double tau_h : {3.0, 12.0})
    for (const double age_h : {1.0, 6.0, 30.0, 200.0}) {
      auto builder = builder_of(lagging_model(tau_h * 3600));
      builder.keep_model_datum();
      observe_constant(builder, -age_h, 0);
      EXPECT_NEAR(temperatures_nm(builder, hours_from_zero(0)),
                  std::hypot(kUnknownPast_nm * std::exp(-age_h / tau_h), kCertificate_nm), 0.1)
          << tau_h << " h, read for " << age_h << " h";
    }
}

// What was before the readings is the same past at the zero and after it.
TEST(SnapshotBuilder, AMemoryThatBeganLatelyBeforeTheZeroStaysUncertainInThatDatum) {
  auto builder = builder_of(lagging_model(3600));
  observe_constant(builder, -1, 0);
  ASSERT_TRUE(builder.anchor(std::vector<ChannelValue>{{"q1_mm", 0.0}, {"t07_degC", 21.0}}));
  EXPECT_NEAR(temperatures_nm(builder, hours_from_zero(0)), 0, 1e-6);
  observe_constant(builder, 0, 1);
  const double at_zero_nm = kUnknownPast_nm * std::exp(-1.0);
  EXPECT_NEAR(temperatures_nm(builder, hours_from_zero(1)), at_zero_nm * (1 - std::exp(-1.0)), 0.1);
  observe_constant(builder, 1, 60);
  EXPECT_NEAR(temperatures_nm(builder, hours_from_zero(60)), at_zero_nm, 0.1);
}

// The same law written for kelvin; the cell's thermometer reads degrees.
TEST(SnapshotBuilder, ServesAModelFittedInKelvinFromAThermometerInDegrees) {
  auto degrees = axis_model();
  degrees.outputs[0].covariance.setZero();  // it is the covariance of other coefficients in kelvin
  auto kelvin = degrees;
  kelvin.domain[1] = {{"t07", "K"}, 293.15, 295.15};
  auto& coefficients = kelvin.outputs[0].coefficients;
  coefficients[0] -= 273.15 * coefficients[3];
  coefficients[1] -= 273.15 * coefficients[4];
  auto in_kelvin = builder_of(kelvin), in_degrees = builder_of(degrees);
  EXPECT_EQ(in_kelvin.observed_channels(), std::vector<std::string>{"t07_degC"});
  for (auto* builder : {&in_kelvin, &in_degrees}) {
    observe(*builder, 21.5);
    ASSERT_TRUE(builder->anchor(std::vector<ChannelValue>{{"q1_mm", 0.5}, {"t07_degC", 20.5}}));
  }
  const auto one = target_at(in_kelvin, 1.5), other = target_at(in_degrees, 1.5);
  EXPECT_NEAR(one.q_mm[0], other.q_mm[0], 1e-12);
  EXPECT_EQ(one.flags, 0U);
  EXPECT_NEAR(one.u_nm[0], other.u_nm[0], 1e-6 * other.u_nm[0]);
}

TEST(SnapshotBuilder, StatesTheBudgetOfAModelFittedInKelvin) {
  auto kelvin = axis_model();
  kelvin.domain[1] = {{"t07", "K"}, 293.15, 295.15};
  const auto snapshot = model_snapshot(kelvin, axis_cell());
  ASSERT_TRUE(snapshot) << snapshot.error().message;
  EXPECT_EQ(snapshot->missing, 0U);
  EXPECT_NEAR(snapshot->inputs.back().value, 294.15, 1e-9);
}

TEST(SnapshotBuilder, IgnoresAReadingThatArrivesLate) {
  auto builder = builder_of(axis_model());
  observe(builder, 21);
  const double q = target_at(builder, 0).q_mm[0];
  observe(builder, 25, kBuiltAt - std::chrono::seconds(1));
  EXPECT_EQ(target_at(builder, 0).q_mm[0], q);
}

TEST(SnapshotBuilder, RefusesModelsThatCannotServeTargets) {
  const auto reason = [](const calibration::Model& model) {
    const auto made = SnapshotBuilder::create(model, ModelId{1}, axis_cell());
    return made ? std::string("served") : made.error().reason;
  };
  auto model = axis_model();
  model.outputs[0].channel = {"x", "mm"};
  EXPECT_EQ(reason(model), "NOT_A_MOTOR_MODEL");
  model = axis_model();
  model.outputs[0].terms[3] = term({power("q2")});
  model.domain.push_back({{"q2", "mm"}, 0, 1});
  EXPECT_EQ(reason(model), "TERM_NOT_SERVABLE");
  model = axis_model();
  model.outputs[0].terms[3] = {{effects::Call{"lag", {"x"}, {{600, "s"}}}}};
  EXPECT_EQ(reason(model), "TERM_NOT_SERVABLE");
  model = axis_model();
  model.domain.pop_back();
  EXPECT_EQ(reason(model), "NO_DOMAIN");
  model.outputs.clear();
  EXPECT_EQ(reason(model), "MODEL_TOO_LARGE");
}

}  // namespace
}  // namespace driftwise::compensation
