#include "tests/statistics/case_b_models.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "server/calibration/design/predict.h"
#include "server/formats/formula/formula.h"
#include "tests/statistics/case_b_oracle.h"

namespace driftwise::statistics {
namespace {

template <class T>
T or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

Eigen::MatrixXd columns_of(const CaseBCampaign& campaign, const calibration::OutputModel& model) {
  return or_throw(calibration::raw_columns(campaign.measured, model.terms))
      .rightCols(static_cast<Eigen::Index>(model.terms.size()) - 1);  // without the constant
}

std::string three(const std::vector<CaseBSeed>& seeds, auto value_of) {
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const auto& seed : seeds) values.push_back(value_of(seed, axis));
    char cell[32];
    std::snprintf(cell, sizeof cell, "%6.1f", median_of(values));
    text += cell;
  }
  return text;
}

std::string ratio_text(const std::vector<double>& all) {
  const auto within = std::ranges::count_if(all, [](double ratio) { return ratio <= 1.15; });
  char text[64];
  std::snprintf(text, sizeof text, "  %.3f  %3d of %d", median_of(all), static_cast<int>(within),
                static_cast<int>(all.size()));
  return text;
}

}  // namespace

const std::vector<CaseBModel>& case_b_models() {
  static const std::string full = "q ~ poly(x, y, z, 3) + F + F^2 + F^3 + t04..t10";
  static const std::vector<CaseBModel> models = {
      {"G", "q ~ poly(x, y, z, 3)"},
      {"G+F", "q ~ poly(x, y, z, 3) + F + F^2 + F^3"},
      {"G+T", "q ~ poly(x, y, z, 3) + t04..t10"},
      {"G+T+F", full},
      {"+ F, t10 : pose",
       "q ~ poly(x, y, z, 4) + F + F^2 + F^3 + t04..t10 + F:poly(x, y, z, 3) + "
       "t10:poly(x, y, z, 3)"},
      {"+ F, T : pose, BIC",
       "q ~ poly(x, y, z, 4) + F + F^2 + F^3 + t04..t10 + (F + t04..t10):poly(x, y, z, 2)", true},
      {"+ F, t04 : pose",
       "q ~ poly(x, y, z, 4) + F + F^2 + F^3 + t04..t10 + (F + t04):poly(x, y, z, 2)"},
  };
  return models;
}

CaseBFigures case_b_figures(const CaseBCampaign& campaign, const CaseBModel& asked) {
  calibration::FitOptions options;
  options.blocks = 0;
  if (asked.bic) options.criterion = calibration::Criterion::bic;
  const auto model = or_throw(formats::fit_formula(campaign.measured, asked.formula, options));
  CaseBFigures figures;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& output = model.outputs[axis];
    const auto predicted = or_throw(calibration::predict(campaign.measured, output));
    const Eigen::VectorXd q = campaign.robot[axis] + campaign.instruments[axis];
    figures.u90[axis] = u90_inside_nm(campaign, q - predicted);
    const auto columns = columns_of(campaign, output);
    figures.robot_u90[axis] =
        u90_inside_nm(campaign, left_after_calibration(campaign, columns, campaign.robot[axis]));
    figures.instruments_u90[axis] = u90_inside_nm(
        campaign, left_after_calibration(campaign, columns, campaign.instruments[axis]));
    figures.terms[axis] = static_cast<int>(output.terms.size());
  }
  return figures;
}

CaseBSeed case_b_seed(std::uint64_t seed, const std::vector<CaseBModel>& models) {
  const auto campaign = case_b_campaign(seed);
  CaseBSeed out;
  out.seed = seed;
  for (const auto& model : models) out.models.push_back(case_b_figures(campaign, model));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.robot_oracle[axis] = robot_oracle_u90_nm(campaign, axis);
    out.terms_oracle[axis] = terms_oracle(campaign, axis).u90_nm;
  }
  return out;
}

double median_of(std::vector<double> values) {
  std::ranges::sort(values);
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

std::vector<double> ratios(const std::vector<CaseBSeed>& seeds, std::size_t model,
                           std::array<double, 3> CaseBSeed::*oracle) {
  std::vector<double> all;
  for (const auto& seed : seeds)
    for (std::size_t axis = 0; axis < 3; ++axis)
      all.push_back(seed.models[model].u90[axis] / (seed.*oracle)[axis]);
  return all;
}

std::string case_b_table(const std::vector<CaseBSeed>& seeds,
                         const std::vector<CaseBModel>& models) {
  std::string text =
      "medians over the seeds: q1 q2 q3; S90 inside the forces, nm        | over the terms oracle, "
      "over the robot oracle: median, within 1.15\n"
      "                    S90               of it robot       instruments       terms\n";
  for (std::size_t m = 0; m < models.size(); ++m) {
    char name[24];
    std::snprintf(name, sizeof name, "%-18s", models[m].name.c_str());
    const auto part = [&](auto member) {
      return three(seeds, [=](const CaseBSeed& seed, std::size_t axis) {
        return static_cast<double>((seed.models[m].*member)[axis]);
      });
    };
    text += name + part(&CaseBFigures::u90) + part(&CaseBFigures::robot_u90) +
            part(&CaseBFigures::instruments_u90) + part(&CaseBFigures::terms) +
            ratio_text(ratios(seeds, m, &CaseBSeed::terms_oracle)) +
            ratio_text(ratios(seeds, m, &CaseBSeed::robot_oracle)) + "\n";
  }
  const auto oracle = [&](auto member) {
    return three(seeds,
                 [=](const CaseBSeed& seed, std::size_t axis) { return (seed.*member)[axis]; });
  };
  text += "terms oracle      " + oracle(&CaseBSeed::terms_oracle) + "\nrobot oracle      " +
          oracle(&CaseBSeed::robot_oracle) + "\n";
  return text;
}

}  // namespace driftwise::statistics
