// Properties that hold for any data: residuals orthogonal to the model, scale does not matter,
// neither do threads.

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <thread>

#include "server/calibration/design/design.h"
#include "server/calibration/design/predict.h"
#include "server/calibration/linear/row_qr.h"
#include "server/calibration/placed_terms.h"
#include "server/core/data/row_marks.h"
#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"

namespace driftwise::calibration {
namespace {

const std::string kFormula = "q1 ~ poly(x, 3) + T + rate(T, 300 s) + x:t01";

Model fitted(const Dataset& data, const FitOptions& options = {},
             const std::string& formula = kFormula) {
  const auto model = formats::fit_formula(data, formula, options);
  EXPECT_TRUE(model.has_value()) << model.error().message;
  return *model;
}

std::vector<std::string> terms_in(const OutputModel& output) {
  std::vector<std::string> names;
  for (const auto& term : output.terms) names.push_back(effects::notation(term));
  return names;
}

TEST(Fit, LeavesResidualsOrthogonalToEveryTermIn) {
  const Dataset data = make_campaign({});
  const Model model = fitted(data);
  const auto& output = model.outputs[0];
  const auto predicted = predict(data, output);
  const auto columns = raw_columns(data, output.terms);
  ASSERT_TRUE(predicted && columns);
  for (Eigen::Index j = 0; j < columns->cols(); ++j) {
    double dot = 0, column2 = 0, residual2 = 0;
    for (std::size_t row = 0; row < data.rows; ++row) {
      if (data.set_of(row) != PointSet::calibration) continue;
      const auto i = static_cast<Eigen::Index>(row);
      const double residual = data.columns[0].values[row] - (*predicted)[i];
      dot += residual * (*columns)(i, j);
      column2 += (*columns)(i, j) * (*columns)(i, j);
      residual2 += residual * residual;
    }
    // rounding of the prediction, 4 mm * 2e-16, against residuals of 3 nm
    EXPECT_LT(std::abs(dot) / std::sqrt(column2 * residual2), 1e-8)
        << effects::notation(output.terms[static_cast<std::size_t>(j)]);
  }
}

TEST(Fit, FindsTheTermsThatMadeTheData) {
  const Model model = fitted(make_campaign({}));
  EXPECT_THAT(terms_in(model.outputs[0]), testing::IsSupersetOf({"1", "x", "x^2", "t01", "t02"}));
  EXPECT_NEAR(model.outputs[0].accuracy.rmse, 3e-6, 0.5e-6);
  EXPECT_NEAR(*model.outputs[0].accuracy.u90_validation, 1.645 * 3e-6, 1e-6);
}

TEST(Fit, AsksOfWeightsTheirRatiosOnly) {
  Dataset data = make_campaign({});
  data.columns.push_back({{"w", "1"}, {}});
  for (std::size_t i = 0; i < data.rows; ++i)
    data.columns.back().values.push_back(i % 2 == 0 ? 1 : 0.5);
  FitOptions options;
  options.weight_symbol = "w";
  const Model once = fitted(data, options);
  const auto& before = once.outputs[0];
  EXPECT_NEAR(before.accuracy.rmse, 3e-6, 0.6e-6);    // the noise that was put in
  for (const double factor : {2.5e9, 1e-60, 1e28}) {  // 1/variance in 1/mm^2, or in any unit
    Dataset scaled = data;
    for (auto& weight : scaled.columns.back().values) weight *= factor;
    const Model other = fitted(scaled, options);
    const auto& after = other.outputs[0];
    ASSERT_EQ(terms_in(after), terms_in(before)) << factor;
    EXPECT_NEAR(after.accuracy.rmse, before.accuracy.rmse, 1e-9 * before.accuracy.rmse) << factor;
    EXPECT_NEAR(*after.accuracy.u90_validation, *before.accuracy.u90_validation,
                1e-9 * *before.accuracy.u90_validation);
    for (std::size_t k = 0; k < before.report.size(); ++k) {
      EXPECT_NEAR(after.report[k].contribution_rms, before.report[k].contribution_rms,
                  1e-9 * before.report[k].contribution_rms);
      EXPECT_NEAR(after.report[k].standard_error, before.report[k].standard_error,
                  1e-7 * before.report[k].standard_error);
    }
  }
}

TEST(Fit, ChoosesTheSameWhateverTheUnits) {
  const Dataset data = make_campaign({});
  const Model plain = fitted(data);
  Dataset scaled = data;
  for (auto& value : scaled.columns[0].values) value *= 1e6;  // nm
  scaled.columns[0].channel.unit = "nm";
  for (auto& value : scaled.columns[1].values) value *= 1e-3;  // m
  scaled.columns[1].channel.unit = "m";
  for (auto& value : scaled.columns[2].values) value = value * 1024 - 9000;
  const Model other = fitted(scaled);
  EXPECT_EQ(terms_in(plain.outputs[0]), terms_in(other.outputs[0]));
  EXPECT_NEAR(other.outputs[0].accuracy.rmse / plain.outputs[0].accuracy.rmse, 1e6, 1e-2);
}

TEST(Fit, IsTheSameToTheLastBitOnThreads) {
  Dataset data = make_campaign({.rows = 30000});
  FitOptions alone, threaded;
  threaded.executor = [](std::size_t count, const std::function<void(std::size_t)>& job) {
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < count; ++i) threads.emplace_back(job, i);
    for (auto& thread : threads) thread.join();
  };
  const Model one = fitted(data, alone), many = fitted(data, threaded);
  const auto &a = one.outputs[0], &b = many.outputs[0];
  EXPECT_EQ(terms_in(a), terms_in(b));
  EXPECT_EQ(a.coefficients, b.coefficients);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.accuracy.u90_blocks, b.accuracy.u90_blocks);
}

TEST(RowQr, OfBlocksIsTheTriangleOfAllRows) {
  std::srand(7);
  const Eigen::MatrixXd matrix = Eigen::MatrixXd::Random(40000, 12);  // several chains of blocks
  const Eigen::MatrixXd triangle = row_qr(matrix);
  ASSERT_EQ(triangle.rows(), 12);
  const Eigen::MatrixXd gram = matrix.transpose() * matrix;
  EXPECT_LT((triangle.transpose() * triangle - gram).norm() / gram.norm(), 1e-13);
  const Eigen::MatrixXd joined =
      join_triangles({row_qr(matrix.topRows(5)), row_qr(matrix.bottomRows(39995))});
  EXPECT_LT((joined.cwiseAbs() - triangle.cwiseAbs()).norm() / triangle.norm(), 1e-12);
}

TEST(Fit, KeepsForcedTermsAndLeavesExcludedOnesOut) {
  FitOptions options;
  options.forced = {*formats::parse_term("t04")};
  options.excluded = {*formats::parse_term("x^2")};
  options.exclude_channels = {"t01"};
  const Model model = fitted(make_campaign({}), options);
  const auto names = terms_in(model.outputs[0]);
  EXPECT_THAT(names, testing::Contains("t04"));
  EXPECT_THAT(names, testing::Not(testing::Contains("x^2")));
  for (const auto& report : model.outputs[0].report)
    EXPECT_EQ(effects::notation(report.term).find("t01"), std::string::npos);
}

TEST(Fit, WithFirstRowsCalibratesOnThoseAndValidatesOnAll) {
  FitOptions options;
  options.first_rows = 120;
  const Model model = fitted(make_campaign({}), options);
  EXPECT_EQ(model.lineage.rows_calibration, 80);
  EXPECT_EQ(model.lineage.rows_validation, 133);
}

// A passage before every seventh row, as a run has them that returns to zero by itself.
Dataset with_passages(const Dataset& data) {
  Dataset out = data;
  out.rows = 0;
  out.time_s.clear(), out.set.clear();
  for (auto& column : out.columns) column.values.clear();
  for (std::size_t row = 0; row < data.rows; ++row)
    for (const bool passage : {true, false}) {
      if (passage && row % 7 != 0) continue;
      ++out.rows;
      out.time_s.push_back(data.time_s[row] - (passage ? 1 : 0));
      out.set.push_back(data.set_of(row));
      out.excluded.push_back(passage ? kPassageRow : kInUse);
      for (std::size_t k = 0; k < data.columns.size(); ++k)
        out.columns[k].values.push_back(data.columns[k].values[row]);
    }
  return out;
}

TEST(Fit, WithFirstRowsCountsNoPassage) {
  FitOptions options;
  options.first_rows = 120;
  const Dataset plain = make_campaign({});
  const std::string formula = "q1 ~ poly(x, 3) + t01 + t02";  // none has a memory of passages
  const Model model = fitted(with_passages(plain), options, formula);
  EXPECT_EQ(model.lineage.rows_calibration, 80);
  EXPECT_EQ(model.lineage.rows_validation, 133);
  EXPECT_EQ(model.outputs[0].coefficients, fitted(plain, options, formula).outputs[0].coefficients);
}

TEST(Fit, OfRunsNamesAWrongRowByItsInstant) {
  Dataset data = with_passages(make_campaign({}));
  data.columns.push_back({{"w", "1"}, std::vector<double>(data.rows, 1.0)});
  data.columns.back().values[100] = -2;
  FitOptions options;
  options.weight_symbol = "w";
  const auto of_file = formats::fit_formula(data, "q1 ~ x", options);
  ASSERT_FALSE(of_file);
  EXPECT_THAT(of_file.error().message, testing::StartsWith("row 101 (time_s "));
  options.lineage.runs = {RunId{3}};
  const auto of_run = formats::fit_formula(data, "q1 ~ x", options);
  ASSERT_FALSE(of_run);
  EXPECT_THAT(of_run.error().message, testing::StartsWith("run 3, the row at time_s "));
}

TEST(Fit, CountsRowsWithAMissingValue) {
  Dataset data = make_campaign({});
  data.columns[3].values[10] = kMissing;
  data.columns[0].values[300] = kMissing;
  const Model model = fitted(data, {}, "q1 ~ x + x^2 + T");
  EXPECT_EQ(model.lineage.rows_dropped, 2);
  EXPECT_THAT(model.warnings, testing::Contains("2 rows dropped for missing values"));
}

Dataset without_rows(const Dataset& data, const std::vector<std::size_t>& rows) {
  Dataset rest;
  for (const auto& column : data.columns) rest.columns.push_back({column.channel, {}});
  for (std::size_t row = 0; row < data.rows; ++row) {
    if (std::ranges::find(rows, row) != rows.end()) continue;
    ++rest.rows;
    rest.time_s.push_back(data.time_s[row]);
    rest.set.push_back(data.set[row]);
    for (std::size_t c = 0; c < data.columns.size(); ++c)
      rest.columns[c].values.push_back(data.columns[c].values[row]);
  }
  return rest;
}

TEST(Fit, OfDataWithExcludedRowsIsTheFitOfTheOthers) {
  const Dataset good = make_campaign({});
  Dataset data = good;
  const std::vector<std::size_t> bad = {3, 40, 41, 42, 200};  // 41, 200: validation
  data.excluded.assign(data.rows, 0);
  for (const auto row : bad) {
    data.excluded[row] = 1;
    data.columns[0].values[row] += 1;  // a lost fringe, and worse
  }
  data.columns[1].values[3] = HUGE_VAL;
  const std::string formula = "q1 ~ poly(x, 3) + T + x:t01";
  const Model marked = fitted(data, {}, formula);
  const Model removed = fitted(without_rows(good, bad), {}, formula);
  EXPECT_EQ(marked.outputs[0].coefficients, removed.outputs[0].coefficients);
  EXPECT_EQ(marked.outputs[0].covariance, removed.outputs[0].covariance);
  EXPECT_EQ(marked.outputs[0].accuracy.u90_validation, removed.outputs[0].accuracy.u90_validation);
  EXPECT_EQ(marked.outputs[0].accuracy.u90_blocks, removed.outputs[0].accuracy.u90_blocks);
  EXPECT_EQ(marked.lineage.rows_calibration, removed.lineage.rows_calibration);
  EXPECT_EQ(marked.lineage.rows_validation, removed.lineage.rows_validation);
  EXPECT_EQ(marked.lineage.rows_excluded, 5);
  EXPECT_EQ(marked.lineage.rows_dropped, 0);
}

// A row is excluded for what was measured at it; the room's temperature at that instant is as true
// as before, and a lag must not miss it.
TEST(Fit, LetsEffectsWithMemorySeeExcludedRows) {
  Dataset data = make_campaign({});
  const auto before = raw_columns(data, {*formats::parse_term("lag(t01, 600 s)")});
  data.excluded.assign(data.rows, 0);
  data.excluded[50] = 1;
  const auto after = raw_columns(data, {*formats::parse_term("lag(t01, 600 s)")});
  ASSERT_TRUE(before && after);
  EXPECT_EQ(*before, *after);
}

TEST(Fit, FitsEveryOutputFromOneTriangle) {
  Dataset data = make_campaign({});
  data.columns.push_back({{"q2", "mm"}, data.columns[0].values});
  for (std::size_t i = 0; i < data.rows; ++i)
    data.columns.back().values[i] += 1e-4 * data.columns[4].values[i];
  const Model both = fitted(data, {}, "q ~ poly(x, 3) + T");
  ASSERT_EQ(both.outputs.size(), 2u);
  const Model alone = fitted(data, {}, "q2 ~ poly(x, 3) + T");
  EXPECT_EQ(terms_in(both.outputs[1]), terms_in(alone.outputs[0]));
  EXPECT_LT((both.outputs[1].coefficients - alone.outputs[0].coefficients).norm(), 1e-10);
}

TEST(Fit, ReportsTheDomainOfWhatItUses) {
  const Model model = fitted(make_campaign({}));
  ASSERT_FALSE(model.domain.empty());
  EXPECT_EQ(model.domain[0].channel.symbol, "x");
  EXPECT_NEAR(model.domain[0].min, -4, 1e-3);
  EXPECT_NEAR(model.domain[0].max, 4, 1e-3);
}

// Terms that belong to some of the outputs only (placed_terms.h).

// q1 and q2 over x and two thermometers; q1 alone goes with t02.
Dataset two_motors() {
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise_mm(0, 3e-6);
  Dataset data;
  data.rows = 160;
  for (const char* symbol : {"q1", "q2", "x"}) data.columns.push_back({{symbol, "mm"}, {}});
  for (const char* symbol : {"t01", "t02"}) data.columns.push_back({{symbol, "degC"}, {}});
  for (std::size_t row = 0; row < data.rows; ++row) {
    const double x = -4 + 8.0 * static_cast<double>(row * 37 % 160) / 160;
    const double t1 = 20 + 0.5 * std::sin(0.05 * static_cast<double>(row));
    const double t2 = 20 + 0.3 * std::cos(0.11 * static_cast<double>(row)) + 0.2 * (t1 - 20);
    data.time_s.push_back(20.0 * static_cast<double>(row));
    const double values[] = {1 + 1.0002 * x + 2e-5 * t1 + 4e-5 * t2 + noise_mm(random),
                             2 - 0.9 * x + 1e-5 * t1 + noise_mm(random), x, t1, t2};
    for (std::size_t c = 0; c < data.columns.size(); ++c)
      data.columns[c].values.push_back(values[c]);
  }
  return data;
}

FitOptions options_for(const Dataset& data, const std::string& formula, Select select) {
  FitOptions options;
  options.candidates = *formats::Formula::parse(formula)->expand(data);
  options.select = select;
  return options;
}

const effects::Term kT2 = *formats::parse_term("t02");

// Outputs are fitted each by itself: with the term in one, that is the fit with it, and the other
// is the fit without it, to the last figures.
class PlacedTerms : public testing::TestWithParam<Select> {};
TEST_P(PlacedTerms, AreFittedInTheirOwnOutputsAndLeaveTheOthersAsTheyWere) {
  const auto data = two_motors();
  const auto placed = fit_placed(data, options_for(data, "q ~ x + t01", GetParam()),
                                 {{kT2, {"q1"}}}, "q ~ x + t01 + t02")
                          .value();
  const auto with = fit(data, options_for(data, "q1 ~ x + t01 + t02", Select::all)).value();
  const auto without = fit(data, options_for(data, "q2 ~ x + t01", Select::all)).value();
  const OutputModel* expected[] = {&with.outputs[0], &without.outputs[0]};
  for (std::size_t o = 0; o < 2; ++o) {
    const auto& is = placed.outputs[o];
    ASSERT_EQ(is.terms, expected[o]->terms);
    for (Eigen::Index k = 0; k < is.coefficients.size(); ++k)
      EXPECT_NEAR(is.coefficients[k], expected[o]->coefficients[k],
                  1e-6 * std::sqrt(expected[o]->covariance(k, k)));
    EXPECT_NEAR(is.accuracy.rmse, expected[o]->accuracy.rmse, 1e-6 * expected[o]->accuracy.rmse);
    EXPECT_NEAR(*is.accuracy.u90_blocks, *expected[o]->accuracy.u90_blocks,
                1e-6 * *expected[o]->accuracy.u90_blocks);
  }
  EXPECT_EQ(placed.formula, "q ~ x + t01 + t02");
}
INSTANTIATE_TEST_SUITE_P(Table, PlacedTerms, testing::Values(Select::all, Select::stepwise),
                         [](const auto& row) {
                           return std::string(row.param == Select::all ? "all" : "stepwise");
                         });

// A motor that slips by 50 nm at 1610 s: the constant is that of where it is now.
TEST(PlacedTerm, ThatStaysEndsInTheConstant) {
  auto data = two_motors();
  const double slip_mm = 50e-6;
  const auto options = options_for(data, "q ~ x + t01", Select::all);
  const auto before = fit(data, options).value();
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.time_s[row] > 1610) data.columns[1].values[row] += slip_mm;
  const auto after =
      fit_placed(data, options, {{*formats::parse_term("step(1610 s)"), {"q2"}, true}},
                 options.candidates.formula)
          .value();
  const auto &was = before.outputs[1], &is = after.outputs[1];
  ASSERT_EQ(is.terms, was.terms);
  const auto at_20_degC = [](const OutputModel& output) {
    return output.coefficients[0] + 20 * output.coefficients[2];
  };
  // Noise of 3 nm in 80 rows on either side: 0.5 nm of the step.
  EXPECT_NEAR(at_20_degC(is) - at_20_degC(was), slip_mm, 2e-6);
  EXPECT_NEAR(is.accuracy.rmse, was.accuracy.rmse, 0.02 * was.accuracy.rmse);
  EXPECT_EQ(is.covariance.rows(), is.coefficients.size());
  EXPECT_EQ(after.outputs[0].coefficients.size(), 3);
}

TEST(PlacedTerm, ThatTheFormulaHasStaysInEveryOutput) {
  const auto data = two_motors();
  const auto options = options_for(data, "q ~ x + t01", Select::all);
  const auto model =
      fit_placed(data, options, {{*formats::parse_term("t01"), {"q1"}}}, options.candidates.formula)
          .value();
  EXPECT_EQ(model.outputs[1].terms.size(), 3u);
}

}  // namespace
}  // namespace driftwise::calibration
