#include "server/diagnosis/separating/hypothesis.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "server/core/try.h"
#include "server/core/units.h"
#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/noise/noise_model.h"
#include "server/diagnosis/rows/aliases.h"
#include "server/diagnosis/rows/problem.h"
#include "server/diagnosis/search/column_bank.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kLongestOpen = 4000;  // blocks
constexpr std::size_t kMostOpenCells = 24;  // of one hypothesis, spread over what is open
constexpr double kLooseShare = 0.04;        // of a period: how far off a lattice a point may be

Eigen::MatrixXd base_and(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

// Every output's series under its noise, freed of what the simulation explains already.
class OpenFit {
 public:
  OpenFit(const Problem& problem, const Diagnosis& diagnosis, const Eigen::MatrixXd& base)
      : problem_(problem) {
    const Eigen::MatrixXd learned = problem.learned(base);
    for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
      const NoiseShape shape = noise_of(diagnosis.outputs[o]);
      Side side{Whitener(problem.timeline, shape), learned, {}, {}, 1};
      side.whitener.apply(side.base);
      side.qr.compute(side.base);
      Eigen::MatrixXd series = problem.learned(problem.outputs[o].measured);
      side.whitener.apply(series);
      side.left = freed(side, series);
      if (diagnosis.outputs[o].noise_white_sd > 0) side.sd = diagnosis.outputs[o].noise_white_sd;
      sides_.push_back(std::move(side));
    }
  }

  // Growth of 2 ln L with these columns (every row of the dataset); coefficients: columns x
  // outputs, 0 where the cause may not act.
  double gain(const Eigen::MatrixXd& all, const std::vector<char>& on,
              Eigen::MatrixXd& coefficients) const {
    double total = 0;
    coefficients.setZero(all.cols(), static_cast<Eigen::Index>(sides_.size()));
    const Eigen::MatrixXd learned = problem_.learned(all);
    for (std::size_t o = 0; o < sides_.size(); ++o) {
      if (on[o] == 0) continue;
      const Side& side = sides_[o];
      Eigen::MatrixXd columns = learned;
      side.whitener.apply(columns);
      columns = freed(side, columns);
      const Eigen::VectorXd b = columns.colPivHouseholderQr().solve(side.left);
      total +=
          (side.left.squaredNorm() - (side.left - columns * b).squaredNorm()) / (side.sd * side.sd);
      coefficients.col(static_cast<Eigen::Index>(o)) = b;
    }
    return total;
  }

 private:
  struct Side {
    Whitener whitener;
    Eigen::MatrixXd base;  // whitened
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
    Eigen::VectorXd left;
    double sd;
  };
  static Eigen::MatrixXd freed(const Side& side, const Eigen::MatrixXd& columns) {
    return columns - side.base * side.qr.solve(columns);
  }

  const Problem& problem_;
  std::vector<Side> sides_;
};

// The best first; then those that the data leave open, thinned out evenly.
void keep_open(Hypothesis& hypothesis) {
  auto& cells = hypothesis.cells;
  double best = -1e300;
  for (const auto& cell : cells) best = std::max(best, -cell.below_2lnl);  // gains so far
  for (auto& cell : cells) cell.below_2lnl = best + cell.below_2lnl;
  std::erase_if(cells, [](const auto& cell) { return cell.below_2lnl > kOpen2lnl; });
  std::ranges::stable_sort(cells, {}, &HypothesisCell::below_2lnl);
  if (cells.size() <= kMostOpenCells) return;
  std::vector<HypothesisCell> kept;
  for (std::size_t i = 0; i < kMostOpenCells; ++i)
    kept.push_back(cells[i * cells.size() / kMostOpenCells]);
  cells = std::move(kept);
}

// The values that a periodic cause is periodic in, in the unit of its period: nm, arcsec or s.
std::vector<double> phase_values(const Dataset& dataset, const effects::Term& term) {
  const auto* call = std::get_if<effects::Call>(&term.factors.front());
  if (call == nullptr) return {};
  if (call->symbols.empty()) return dataset.time_s;
  const auto own = dataset.values_of(call->symbols.front());
  std::vector<double> values(own.begin(), own.end());
  if (call->parameters.front().unit == "nm")
    for (double& value : values) value = nm_from_mm(value);
  return values;
}

// "2000 nm", "57.1 s"
std::string period_text(const Cause& cause, double period) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g %s", period,
                cause.parameter == "period_nm"       ? "nm"
                : cause.parameter == "period_arcsec" ? "arcsec"
                                                     : "s");
  return text.data();
}

class OpenSet {
 public:
  OpenSet(const Dataset& dataset, const Problem& problem, const OpenFit& fit)
      : dataset_(dataset), problem_(problem), fit_(fit) {}

  Result<void> add(const Cause& cause, const std::vector<effects::Term>* refined) {
    Hypothesis hypothesis{.cause = cause.id, .name = name_of(cause)};
    if (refined != nullptr)
      if (auto ok = add_cell(hypothesis, cause, *refined); !ok) return ok;
    for (const auto& cell : cause.cells)
      if (auto ok = add_cell(hypothesis, cause, cell.terms); !ok) return ok;
    keep_open(hypothesis);
    if (!hypothesis.cells.empty()) hypotheses.push_back(std::move(hypothesis));
    return {};
  }

  Result<void> add_aliases(const Cause& cause, const std::vector<effects::Term>& terms,
                           double period) {
    const auto values = phase_values(dataset_, terms.front());
    const double spacing = lattice_spacing(values, kLooseShare * period);
    for (const double alias : aliased_periods(period, spacing)) {
      if (lattice_spacing(values, kLooseShare * alias) == 0) continue;  // not a lattice for it
      Hypothesis hypothesis{.cause = cause.id,
                            .name = name_of(cause) + " of " + period_text(cause, alias)};
      if (auto ok = add_cell(hypothesis, cause, with_parameter(terms, alias)); !ok) return ok;
      keep_open(hypothesis);
      hypotheses.push_back(std::move(hypothesis));
    }
    return {};
  }

  std::vector<Hypothesis> hypotheses;

 private:
  Result<void> add_cell(Hypothesis& hypothesis, const Cause& cause,
                        const std::vector<effects::Term>& terms) {
    DRIFTWISE_TRY(auto columns, filled_columns(problem_, terms));
    HypothesisCell cell{.terms = terms, .coefficients = {}};
    cell.below_2lnl = -fit_.gain(columns, acts_on(problem_, cause), cell.coefficients);
    hypothesis.cells.push_back(std::move(cell));
    return {};
  }

  const Dataset& dataset_;
  const Problem& problem_;
  const OpenFit& fit_;
};

}  // namespace

NoiseShape noise_of(const OutputSummary& output) {
  if (!(output.noise_white_sd > 0) || !(output.noise_tau_s > 0)) return {};
  const double ratio = output.noise_slow_sd / output.noise_white_sd;
  return {.slow_ratio = ratio * ratio, .tau_s = output.noise_tau_s};
}

Result<std::vector<Hypothesis>> open_hypotheses(const Dataset& dataset,
                                                const calibration::Candidates& baseline,
                                                const Diagnosis& diagnosis, std::size_t finding) {
  DRIFTWISE_TRY(auto problem, lay_out(dataset, baseline, kLongestOpen));
  std::vector<effects::Term> others;
  for (std::size_t i = 0; i < diagnosis.findings.size(); ++i) {
    const auto& one = diagnosis.findings[i];
    if (one.cause == "outliers") problem.leave_out(one.rows);
    if (i != finding) others.insert(others.end(), one.terms.begin(), one.terms.end());
  }
  problem.lay_blocks(kLongestOpen);
  Eigen::MatrixXd base = problem.base_columns;
  if (!others.empty()) {
    DRIFTWISE_TRY(const auto columns, filled_columns(problem, others));
    base = base_and(base, columns);
  }
  const OpenFit fit(problem, diagnosis, base);
  OpenSet open(dataset, problem, fit);
  const Finding& asked = diagnosis.findings[finding];
  const std::string own = asked.cause + (asked.subject.empty() ? "" : " " + asked.subject);
  Dataset conditions = problem.prepared.conditions();
  conditions.time_s = problem.data().time_s;
  const auto catalogue = catalogue_for(conditions, problem.base, {});
  for (const auto& cause : catalogue.causes) {
    const bool itself = name_of(cause) == own;
    if (!itself && std::ranges::find(asked.indistinguishable_from, name_of(cause)) ==
                       asked.indistinguishable_from.end())
      continue;
    DRIFTWISE_RETURN_IF_ERROR(open.add(cause, itself ? &asked.terms : nullptr));
    if (itself && cause.scale == ParameterScale::inverse && !asked.parameters.empty())
      DRIFTWISE_RETURN_IF_ERROR(
          open.add_aliases(cause, asked.terms, asked.parameters.front().value));
    if (itself && open.hypotheses.size() > 1)
      std::rotate(open.hypotheses.begin(),
                  std::ranges::find(open.hypotheses, own, &Hypothesis::name),
                  open.hypotheses.end());
  }
  return std::move(open.hypotheses);
}

}  // namespace driftwise::diagnosis
