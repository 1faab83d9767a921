#include "server/diagnosis/check/check_standard.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "server/calibration/linear/tail.h"
#include "server/calibration/model/fit_options.h"
#include "server/calibration/report/residual_statistics.h"
#include "server/core/data/accuracy.h"
#include "server/core/data/row_marks.h"
#include "server/core/units.h"
#include "server/diagnosis/answer/shares.h"
#include "server/diagnosis/check/check_memory.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kInside = 0.99865;  // of a normal distribution below 3 sigma
constexpr double kLambda = 0.2;      // e-Handbook 6.3.2.4: between 0.2 and 0.3
constexpr double kSigmas = 3;
constexpr double kFewestDof = 3;

template <class... Values>
std::string sentence(const char* format, Values... values) {
  char text[320];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

double thinned_for_variance(double rows, double lag1) {
  return rows * (1 - lag1 * lag1) / (1 + lag1 * lag1);
}

CheckReference reference_of(const calibration::OutputModel& output, std::int64_t rows) {
  const auto& accuracy = output.accuracy;
  const double factor = summary_unit(output.channel.unit).factor;
  CheckReference reference;
  reference.lag1_autocorrelation = std::clamp(accuracy.lag1_autocorrelation, 0.0, 0.99);
  const double most_dof = std::max(
      kFewestDof, thinned_for_variance(static_cast<double>(rows), reference.lag1_autocorrelation) -
                      static_cast<double>(output.terms.size()));
  reference.dof = most_dof;
  if (accuracy.a90_blocks && *accuracy.a90_blocks > 0) {
    reference.sd = *accuracy.a90_blocks / kSigmaToU90 * factor;
    reference.source = "blocks of time";
    if (accuracy.a90_blocks_high && *accuracy.a90_blocks_high > *accuracy.a90_blocks) {
      // The interval is 90 % by t over the blocks on ln(mean square), whose variance is 2 / dof for
      // a variance with that many degrees of freedom.
      const double blocks = accuracy.block_count.value_or(calibration::FitOptions{}.blocks);
      const double t = calibration::t_quantile(0.95, std::max(1.0, blocks - 1));
      const double se = 2 * std::log(*accuracy.a90_blocks_high / *accuracy.a90_blocks) / t;
      reference.dof = std::clamp(2 / (se * se), kFewestDof, most_dof);
    }
  } else if (accuracy.a90_validation && *accuracy.a90_validation > 0) {
    reference.sd = *accuracy.a90_validation / kSigmaToU90 * factor;
    reference.source = "validation rows";
  } else {
    reference.sd = accuracy.rmse * factor;
    reference.source = "residuals";
  }
  return reference;
}

// The one channel that explains most of a run's errors: " (x explains 93 % of it)".
std::string what_it_goes_with(const RunToCheck& run, const std::vector<double>& errors,
                              const std::string& output) {
  constexpr double kWorthNaming = 0.3;
  double most = kWorthNaming;
  std::string name;
  for (const auto& column : run.data.columns) {
    const auto& symbol = column.channel.symbol;
    if (symbol == output || symbol.ends_with("_cmd") || symbol.ends_with("_std") ||
        symbol.ends_with("_target"))
      continue;
    const double share = marginal_share(column.values, errors);
    if (share <= most) continue;
    most = share;
    name = symbol;
  }
  return name.empty() ? std::string()
                      : sentence(" (%s explains %.0f %% of it)", name.c_str(), 100 * most);
}

// A series whose points share a part (in proportion to shared) and have a part of their own.
class Ewma {
 public:
  void add(double value, double own_variance, double shared_sd) {
    const double keep = count_ == 0 ? 0 : 1 - kLambda;
    const double take = count_ == 0 ? 1 : kLambda;
    value_ = take * value + keep * value_;
    own_variance_ = take * take * own_variance + keep * keep * own_variance_;
    shared_sd_ = take * shared_sd + keep * shared_sd_;
    ++count_;
  }
  bool tells() const { return count_ >= 2; }
  double value() const { return value_; }
  double limit() const { return kSigmas * std::sqrt(own_variance_ + shared_sd_ * shared_sd_); }

 private:
  int count_ = 0;
  double value_ = 0, own_variance_ = 0, shared_sd_ = 0;
};

class Charts {
 public:
  explicit Charts(CheckReference reference) : reference_(std::move(reference)) {}

  // errors: not empty. Fills the figures and what is out of control.
  void judge(const RunErrors& errors, const std::string& name, const std::string& unit,
             CheckPoint& point) {
    std::vector<double> known;
    for (const double value : errors.values)
      if (std::isfinite(value)) known.push_back(value);
    const double n = static_cast<double>(known.size());
    const double r = reference_.lag1_autocorrelation;
    point.effective_rows = calibration::effective_rows(point.rows, r);
    const ErrorFigures figures = error_figures(known);
    point.bias = figures.mean;
    point.sd = figures.u90 / kSigmaToU90;
    point.u90 = figures.u90;
    point.a90 = figures.a90;
    const double dof = thinned_for_variance(n, r) - 1;
    if (dof < kFewestDof || !(reference_.sd > 0)) {
      point.why_not = reference_.sd > 0
                          ? sentence("%.0f rows, as good as %.1f independent ones, are too few", n,
                                     std::max(0.0, dof + 1))
                          : "the model has no error to compare with";
      return;
    }
    point.judged = true;
    judge_bias(errors, name, unit, point);
    judge_spread(errors, dof, name, unit, point);
  }

 private:
  void judge_bias(const RunErrors& errors, const std::string& name, const std::string& unit,
                  CheckPoint& point) {
    if (!errors.anchored) return;
    const double variance = reference_.sd * reference_.sd;
    const double own = variance / point.effective_rows + variance;  // of the points, of the zero
    point.bias_limit = calibration::t_quantile(kInside, reference_.dof) *
                       std::sqrt(own + errors.model_mean_variance);
    if (std::abs(point.bias) > *point.bias_limit)
      point.out_of_control.push_back(sentence("%s errs by %+.1f %s on average, limit %.1f",
                                              name.c_str(), point.bias, unit.c_str(),
                                              *point.bias_limit));
    bias_.add(point.bias, own, std::sqrt(errors.model_mean_variance));
    if (!bias_.tells()) return;
    point.ewma_bias = bias_.value();
    point.ewma_bias_limit = bias_.limit();
    if (std::abs(bias_.value()) > bias_.limit())
      point.out_of_control.push_back(
          sentence("%s errs by %+.1f %s on average over the last runs (EWMA), limit %.1f",
                   name.c_str(), bias_.value(), unit.c_str(), bias_.limit()));
  }

  void judge_spread(const RunErrors& errors, double dof, const std::string& name,
                    const std::string& unit, CheckPoint& point) {
    const double variance = reference_.sd * reference_.sd;
    const double expected =
        variance + std::max(0.0, errors.model_variance - errors.model_mean_variance);
    point.sd_limit = std::sqrt(expected * calibration::f_quantile(kInside, dof, reference_.dof));
    if (point.sd > point.sd_limit)
      point.out_of_control.push_back(sentence("%s's error spreads by %.1f %s, limit %.1f",
                                              name.c_str(), point.sd, unit.c_str(),
                                              point.sd_limit));
    // ln of a mean square with dof degrees of freedom: mean -1/dof, variance 2/dof, nearly.
    spread_.add(std::log(std::max(1e-12, point.sd * point.sd / expected)) + 1 / dof, 2 / dof,
                std::sqrt(2 / reference_.dof));
    if (!spread_.tells()) return;
    point.ewma_spread = spread_.value();
    point.ewma_spread_limit = spread_.limit();
    if (spread_.value() > spread_.limit())
      point.out_of_control.push_back(
          sentence("%s's error spreads %.2f times as much as expected over the last runs (EWMA), "
                   "limit %.2f",
                   name.c_str(), std::exp(spread_.value() / 2), std::exp(spread_.limit() / 2)));
  }

  CheckReference reference_;
  Ewma bias_, spread_;
};

OutputCheck check_output(const calibration::Model& model, const calibration::OutputModel& output,
                         std::span<const Result<RunToCheck>> runs,
                         std::span<const RunToCheck> asked) {
  OutputCheck check{output.channel,
                    summary_unit(output.channel.unit).unit,
                    reference_of(output, model.lineage.rows_calibration),
                    {}};
  Charts charts(check.reference);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    CheckPoint point;
    point.run = asked[i].run;
    if (!runs[i]) {
      point.why_not = runs[i].error().message;
      check.points.push_back(std::move(point));
      continue;
    }
    const RunToCheck& run = *runs[i];
    point.excluded = static_cast<std::int64_t>(count_kept_out(run.data));
    const auto errors = run_errors(output, model.lineage.rows_calibration, run);
    if (!errors) {
      point.why_not = errors.error().message;
    } else if (errors->rows == 0) {
      point.why_not = run.unknown_memory.empty() ? "no row has every channel that the model needs"
                                                 : run.unknown_memory;
    } else {
      point.rows = errors->rows;
      charts.judge(*errors, output.channel.symbol, check.unit, point);
      if (!point.out_of_control.empty())
        point.out_of_control.front() +=
            what_it_goes_with(run, errors->values, output.channel.symbol);
    }
    check.points.push_back(std::move(point));
  }
  return check;
}

}  // namespace

CheckReport check_model(const calibration::Model& model, std::span<const RunToCheck> runs) {
  CheckReport report;
  const auto plain = with_effects_as_channels(model);
  std::vector<Result<RunToCheck>> ready;
  for (const auto& run : runs) ready.push_back(as_the_model_reads(model, run));
  for (const auto& output : plain.outputs)
    report.outputs.push_back(check_output(plain, output, ready, runs));
  for (std::size_t back = runs.size(); back-- > 0;) {
    bool judged = false;
    for (const auto& output : report.outputs) {
      const auto& point = output.points[back];
      judged = judged || point.judged;
      for (const auto& reason : point.out_of_control)
        report.reasons.push_back("run " + std::to_string(point.run.value) + ": " + reason);
    }
    if (!judged) continue;
    report.verdict = report.reasons.empty() ? CheckVerdict::in_control : CheckVerdict::recalibrate;
    break;
  }
  return report;
}

}  // namespace driftwise::diagnosis
