#include "server/identification/method.h"

#include <algorithm>
#include <array>

#include "server/calibration/datum_zeros.h"
#include "server/calibration/design/predict.h"
#include "server/core/data/unusable_values.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::identification {
namespace {

using Eigen::Index;

constexpr std::array<std::pair<Method, const char*>, 4> kNames = {
    {{Method::stepwise, "stepwise"},
     {Method::nominal, "nominal"},
     {Method::classic, "classic"},
     {Method::kinematic, "kinematic"}}};

Result<void> check_method(Method method, const MethodOptions& options) {
  if (method != Method::stepwise && !options.mechanism)
    return fail(ErrorCode::invalid_argument, reasons::kNoKinematics,
                "the " + name_of(method) +
                    " method needs the robot's nominal geometry: give a robot file with a "
                    "[kinematics] section (--kinematics robot.toml)");
  const bool needs_formula = method == Method::stepwise || method == Method::classic;
  if (needs_formula && options.fit.candidates.outputs.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoFormula,
                "the " + name_of(method) + " method needs a formula (--model)");
  if (!options.mechanism || options.fit.candidates.outputs.empty() || method == Method::stepwise)
    return {};
  std::vector<std::string> asked = options.fit.candidates.outputs, predicted;
  for (const auto& output : options.mechanism->outputs()) predicted.push_back(output.symbol);
  std::ranges::sort(asked);
  std::ranges::sort(predicted);
  if (asked == predicted) return {};
  std::string left, right, written;
  for (const auto& one : asked) left += (left.empty() ? "" : ", ") + one;
  for (const auto& one : predicted) right += (right.empty() ? "" : ", ") + one;
  for (const auto& one : predicted) written += (written.empty() ? "" : " + ") + one;
  return fail(ErrorCode::invalid_argument, reasons::kOtherOutputs,
              "the left side of the formula has " + left +
                  ", but this robot's kinematics predicts " + right + ": write \"" + written +
                  " ~ ...\"");
}

Result<Identification> identified(const Dataset& dataset, const MethodOptions& options,
                                  bool placement_only) {
  IdentifyOptions asked;
  asked.mechanism = options.mechanism;
  asked.placement_only = placement_only;
  if (!placement_only) {
    asked.terms = options.fit.candidates.terms;
    std::erase_if(asked.terms, [&options](const effects::Term& term) {
      const auto& out = options.fit.excluded;
      return std::ranges::find(out, effects::canonical(term), [](const effects::Term& one) {
               return effects::canonical(one);
             }) != out.end();
    });
    asked.terms.insert(asked.terms.end(), options.fit.forced.begin(), options.fit.forced.end());
  }
  return identify(dataset, asked);
}

// The dataset with what the nominal robot leaves in place of the outputs: e = measured - predicted.
Result<Dataset> error_dataset(const Dataset& dataset, const Identification& nominal) {
  DRIFTWISE_TRY(const auto predicted, predict(dataset, nominal));
  Dataset errors = dataset;
  for (std::size_t o = 0; o < nominal.mechanism->outputs().size(); ++o)
    for (auto& column : errors.columns)
      if (column.channel.symbol == nominal.mechanism->outputs()[o].symbol)
        for (std::size_t row = 0; row < errors.rows; ++row)
          column.values[row] -= predicted(static_cast<Index>(row), static_cast<Index>(o));
  return errors;
}

}  // namespace

std::string name_of(Method method) {
  for (const auto& [known, name] : kNames)
    if (known == method) return name;
  return "";
}

std::optional<Method> method_from(const std::string& name) {
  for (const auto& [known, text] : kNames)
    if (name == text) return known;
  return std::nullopt;
}

std::vector<Method> methods_possible(bool formula, bool mechanism) {
  std::vector<Method> methods;
  if (mechanism) methods.push_back(Method::nominal);
  if (mechanism && formula) methods.push_back(Method::classic);
  if (mechanism) methods.push_back(Method::kinematic);
  if (formula) methods.push_back(Method::stepwise);
  return methods;
}

int FittedMethod::parameters(std::size_t output) const {
  int count = 0;
  if (kinematics) {
    count += static_cast<int>(std::ranges::count(kinematics->free(), 1));
    count += std::max(0, static_cast<int>(kinematics->terms.size()) - 1);
  }
  if (linear)
    for (const auto& model : linear->outputs)
      if (model.channel == outputs[output]) count += static_cast<int>(model.terms.size());
  return count;
}

int FittedMethod::parameters() const {
  int count = kinematics ? kinematics->unknowns : 0;
  if (linear)
    for (const auto& model : linear->outputs) count += static_cast<int>(model.terms.size());
  return count;
}

Result<FittedMethod> fit_method(const Dataset& dataset, Method method,
                                const MethodOptions& options) {
  if (const auto usable = without_unusable(dataset))
    return fit_method(usable->data, method, options);
  DRIFTWISE_RETURN_IF_ERROR(check_method(method, options));
  FittedMethod fitted;
  fitted.method = method;
  const auto& stopwatch = options.fit.stopwatch_us;
  const double start_us = stopwatch ? stopwatch() : 0;
  const Dataset* data = &dataset;
  Dataset errors;
  if (method != Method::stepwise) {
    DRIFTWISE_TRY(auto found, identified(dataset, options, method != Method::kinematic));
    fitted.kinematics = std::move(found);
    fitted.outputs = options.mechanism->outputs();
  }
  if (method == Method::classic) {
    DRIFTWISE_TRY(auto left, error_dataset(dataset, *fitted.kinematics));
    errors = std::move(left);
    data = &errors;
  }
  if (method == Method::stepwise || method == Method::classic) {
    auto asked = options.fit;
    // What a drawing leaves over hardly follows the pose: it cannot tell where a zero lies.
    asked.move_datums = asked.move_datums && method == Method::stepwise;
    DRIFTWISE_TRY(auto model, calibration::fit(*data, asked));
    if (method == Method::stepwise) {
      for (const auto& output : model.outputs) fitted.outputs.push_back(output.channel);
      fitted.fit_us = model.fit_us;
    }
    fitted.linear = std::move(model);
  }
  if (method != Method::stepwise && stopwatch) fitted.fit_us = stopwatch() - start_us;
  return fitted;
}

Result<Eigen::MatrixXd> predict(const Dataset& dataset, const FittedMethod& fitted) {
  Eigen::MatrixXd predicted = Eigen::MatrixXd::Zero(static_cast<Index>(dataset.rows),
                                                    static_cast<Index>(fitted.outputs.size()));
  if (fitted.kinematics) {
    DRIFTWISE_TRY(auto geometric, predict(dataset, *fitted.kinematics));
    predicted = std::move(geometric);
  }
  if (!fitted.linear) return predicted;
  const Dataset moved = calibration::in_first_datum(dataset, fitted.linear->datum_zeros);
  for (const auto& model : fitted.linear->outputs) {
    DRIFTWISE_TRY(const auto own, calibration::predict(moved, model));
    const auto at = std::ranges::find(fitted.outputs, model.channel) - fitted.outputs.begin();
    predicted.col(at) += own;
  }
  return predicted;
}

}  // namespace driftwise::identification
