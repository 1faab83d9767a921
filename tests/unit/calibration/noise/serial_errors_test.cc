// Slow noise found and allowed for: against R's nlme, by coverage on simulated campaigns, by
// properties.

#include "server/calibration/noise/serial_errors.h"

#include <gmock/gmock.h>

#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <random>

#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"
#include "tests/unit/calibration/data_files.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

struct SlowPart {
  double phi = 0, share = 0;  // of the variance
};

// Sum of AR(1) from their stationary starts and white noise, of standard deviation 1.
std::vector<double> slow_noise(std::mt19937& random, std::size_t rows,
                               const std::vector<SlowPart>& parts) {
  std::normal_distribution<double> normal;
  std::vector<double> noise(rows), slow;
  double white = 1;
  for (const auto& part : parts) {
    white -= part.share;
    slow.push_back(normal(random));
  }
  for (auto& one : noise) {
    for (std::size_t i = 0; i < parts.size(); ++i) one += std::sqrt(parts[i].share) * slow[i];
    one += std::sqrt(std::max(white, 0.0)) * normal(random);
    for (std::size_t i = 0; i < parts.size(); ++i)
      slow[i] =
          parts[i].phi * slow[i] + std::sqrt(1 - parts[i].phi * parts[i].phi) * normal(random);
  }
  return noise;
}

TEST(SerialNoise, EqualsTheRestrictedLikelihoodOfNlme) {
  // tests/data/serial_noise/make_serial_golden.R: gls(y ~ x1 + x2, corExp(nugget = TRUE)), REML
  const auto rows = read_rows("serial_noise/golden.csv");
  int sets = 0, alike = 0;
  for (std::size_t at = 0; at < rows.size(); ++sets) {
    ASSERT_EQ(rows[at][0], "set");
    const auto n = static_cast<Index>(std::stoi(rows[at][1]));
    const double sigma = std::stod(rows[at][2]), share = std::stod(rows[at][3]),
                 range = std::stod(rows[at][4]), likelihood = std::stod(rows[at][5]);
    Eigen::MatrixXd x(n, 3);
    Eigen::VectorXd y(n);
    for (Index i = 0; i < n; ++i) {
      const auto& row = rows[at + 1 + static_cast<std::size_t>(i)];
      y[i] = std::stod(row[0]);
      x.row(i) << 1, std::stod(row[1]), std::stod(row[2]);
    }
    const Eigen::VectorXd residuals = y - x * Eigen::HouseholderQR<Eigen::MatrixXd>(x).solve(y);
    SCOPED_TRACE("set " + std::to_string(sets));
    const double dof = static_cast<double>(n) - 3;
    const double constant = dof * (std::log(2 * M_PI) + 1 - std::log(dof));
    EXPECT_NEAR(-(serial_deviance(x, residuals, share, range) + constant) / 2, likelihood, 1e-4);
    const SerialNoise noise = serial_noise(x, residuals);
    const double ours = serial_deviance(x, residuals, noise.share, noise.rows);
    EXPECT_LT(ours, -2 * likelihood - constant + 0.05) << "R found a better one";
    if (ours > -2 * likelihood - constant - 0.05) {  // else R stopped in a lesser optimum
      EXPECT_NEAR(noise.share, share, 0.05);
      EXPECT_NEAR(std::sqrt(noise.variance) / sigma, 1, 0.05);
      ++alike;
    }
    at += 1 + static_cast<std::size_t>(n);
  }
  EXPECT_EQ(sets, 6);
  EXPECT_GE(alike, 5);
}

TEST(CorrelatedGram, IsTheProductWithTheWholeMatrix) {
  std::srand(3);
  const Eigen::MatrixXd z = Eigen::MatrixXd::Random(40, 3);
  const SerialNoise noise{.variance = 2, .share = 0.6, .rows = 5};
  Eigen::MatrixXd whole(40, 40);
  for (Index i = 0; i < 40; ++i)
    for (Index j = 0; j < 40; ++j)
      whole(i, j) = i == j ? 1 : 0.6 * std::exp(-std::abs(static_cast<double>(i - j)) / 5);
  EXPECT_LT((correlated_gram(z, noise) - z.transpose() * whole * z).norm(), 1e-12);
}

// The lower 97.5 % bound of a rate (Clopper-Pearson).
double at_least(int hits, int trials) {
  return boost::math::binomial_distribution<>::find_lower_bound_on_p(trials, hits, 0.025);
}
double at_most(int hits, int trials) {
  return boost::math::binomial_distribution<>::find_upper_bound_on_p(trials, hits, 0.025);
}

struct Coverage {
  int classical = 0, serial = 0, trials = 0;
};

// How often b +- 1.96 standard errors holds the truth, for every term of 200 campaigns in which
// slow temperatures and a position that goes back and forth stand under slow noise.
std::map<std::string, Coverage> coverage(const std::vector<SlowPart>& parts, std::size_t rows) {
  std::map<std::string, Coverage> terms;
  FitOptions options;
  options.select = Select::all;
  options.blocks = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed * 7919);
    Dataset data = make_campaign(
        {.rows = static_cast<int>(rows), .thermometers = 3, .noise_mm = 0, .seed = seed});
    data.set.clear();
    const auto noise = slow_noise(random, rows, parts);
    for (std::size_t i = 0; i < rows; ++i) data.columns[0].values[i] += 3e-6 * noise[i];
    const auto model = formats::fit_formula(data, "q1 ~ x + x^2 + T", options);
    EXPECT_TRUE(model.has_value());
    const std::map<std::string, double> truth = {
        {"x", 1.0001}, {"x^2", 2e-5}, {"t01", 4e-4}, {"t02", -2e-4}, {"t03", 0}};
    for (const auto& report : model->outputs[0].report) {
      const std::string name = effects::notation(report.term);
      if (!truth.contains(name)) continue;
      const double error = std::abs(report.coefficient - truth.at(name));
      auto& term = terms[name];
      ++term.trials;
      term.classical += error < 1.96 * report.standard_error ? 1 : 0;
      term.serial += error < 1.96 * report.standard_error_serial ? 1 : 0;
    }
  }
  return terms;
}

TEST(SerialErrors, CoverTheTruthUnderSlowNoise) {
  // The last: an interferometer's instability of two rows and a stabiliser's wander of fifty.
  for (const auto& parts : std::vector<std::vector<SlowPart>>{
           {}, {{0.5, 1}}, {{0.8, 1}}, {{0.95, 1}}, {{0.95, 0.5}}, {{0.6, 0.5}, {0.98, 0.45}}}) {
    Coverage temperatures, positions;
    for (const auto& [name, term] : coverage(parts, 400)) {
      auto& group = name.front() == 't' ? temperatures : positions;
      group.classical += term.classical;
      group.serial += term.serial;
      group.trials += term.trials;
    }
    std::string label;
    double slow = 0;
    for (const auto& part : parts) {
      label += "phi " + effects::number_text(part.phi) + ", share " +
               effects::number_text(part.share) + "; ";
      slow += part.phi * part.share;
    }
    for (const auto& [what, group] :
         {std::pair("temperatures", temperatures), std::pair("positions", positions)}) {
      const double low = at_least(group.serial, group.trials),
                   high = at_most(group.serial, group.trials);
      std::printf("%-42s %-13s classical %3d of %d, serial %3d (95 %%: %.3f to %.3f)\n",
                  label.c_str(), what, group.classical, group.trials, group.serial, low, high);
      // Promised: 92 to 98 %. The test fails when the interval of what was seen excludes that.
      EXPECT_GE(high, 0.92) << label << what;
      EXPECT_LE(low, 0.98) << label << what;
    }
    if (slow >= 0.7) {
      EXPECT_LT(at_most(temperatures.classical, temperatures.trials), 0.6)
          << "the classical errors were good enough: nothing was tested";
    }
  }
}

TEST(SerialErrors, EqualTheClassicalOnesInWhiteNoise) {
  const auto model = formats::fit_formula(make_campaign({.rows = 3000}), "q1 ~ x + x^2 + T", {});
  for (const auto& report : model->outputs[0].report) {
    if (!report.in) continue;
    EXPECT_NEAR(report.standard_error_serial / report.standard_error, 1, 0.1);
  }
  EXPECT_EQ(model->outputs[0].accuracy.slow_share, 0);
}

TEST(SerialErrors, OfLongDataComeFromStretchesOfIt) {
  std::mt19937 random(12);
  Dataset data = make_campaign({.rows = 60000, .thermometers = 3, .noise_mm = 0});
  data.set.clear();
  const auto noise = slow_noise(random, data.rows, {{0.9, 0.8}});
  for (std::size_t i = 0; i < data.rows; ++i) data.columns[0].values[i] += 3e-6 * noise[i];
  FitOptions options;
  options.select = Select::all;
  options.blocks = 0;
  const auto model = formats::fit_formula(data, "q1 ~ x + x^2 + T", options);
  const auto& output = model->outputs[0];
  EXPECT_NEAR(output.accuracy.slow_share, 0.8, 0.05);
  // 16 384 rows hold about 900 lengths of 2 x 9.5 rows: 5 % is one standard deviation.
  EXPECT_NEAR(output.accuracy.slow_rows, -1 / std::log(0.9), 1.5);
  for (const auto& report : output.report) {
    const double ratio = report.standard_error_serial / report.standard_error;
    const std::string name = effects::notation(report.term);
    // slow against slow: (1 + 0.9) / (1 - 0.9) = 19 times the variance of the slow 80 %
    if (name == "1" || name.front() == 't') {
      EXPECT_NEAR(ratio, std::sqrt(0.8 * 19 + 0.2), 0.6) << name;
    }
    if (name == "x") {
      EXPECT_LT(ratio, 1.3);  // back and forth every 17 rows
    }
  }
}

}  // namespace
}  // namespace driftwise::calibration
