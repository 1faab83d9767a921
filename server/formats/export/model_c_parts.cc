#include "server/formats/export/model_c_parts.h"

#include <algorithm>

#include "server/effects/term_order.h"

namespace driftwise::formats {
namespace {

struct SlowTerm {
  double coefficient;
  std::string product;  // "" for 1
};

// One number of `folded`: what stands before one product of the pose in one output.
struct FoldedNumber {
  std::size_t output;
  std::string pose_product;  // "" for 1
  std::vector<SlowTerm> terms;
};

std::vector<FoldedNumber> folded_numbers(const calibration::Model& model, const CInputs& inputs) {
  std::vector<FoldedNumber> numbers;
  for (std::size_t i = 0; i < model.outputs.size(); ++i)
    for (std::size_t k = 0; k < model.outputs[i].terms.size(); ++k) {
      const auto& term = model.outputs[i].terms[k];
      if (effects::datum_of(term)) continue;
      std::string fast, slow;
      const effects::Term ordered = effects::canonical(term);
      for (const auto& factor : ordered.factors) {
        const auto& power = std::get<effects::Power>(factor);
        const std::string value = inputs.expression(power.symbol);
        std::string& part = value.starts_with("pose[") ? fast : slow;
        part += (part.empty() ? "" : " * ") + c_power(value, power.exponent);
      }
      auto same = std::ranges::find_if(numbers, [&](const FoldedNumber& one) {
        return one.output == i && one.pose_product == fast;
      });
      if (same == numbers.end()) same = numbers.insert(same, {i, fast, {}});
      same->terms.push_back(
          {model.outputs[i].coefficients[static_cast<Eigen::Index>(k)], std::move(slow)});
    }
  return numbers;
}

constexpr const char* kHead = R"(
/* The same in two parts, for a control loop. Slow: @f_fold, every few seconds or when a temperature
 * moves. Fast: @f_fast, per target. folded: room for @f_folded doubles; who folds in another thread
 * than the loop's folds into a second array and hands it over.
 * Returned by both: 0, or the bits of the inputs outside the fitted domain: of the temperatures by
 * @f_fold, of both by @f_fast. @f_fast_from: from another zero, as @f_from. q differs from the
 * function of one part by rounding only. */
enum { @f_folded = @c };
int @f_fold(const double *temperatures, double *folded);
int @f_fast(const double *folded, const double *pose, double *q);
int @f_fast_from(const double *zero, const double *folded, const double *pose, double *q);

)";

constexpr const char* kFrom = R"(
int @f_fast_from(const double *zero, const double *folded, const double *pose, double *q) {
  double at[@m];
  int v, outside;
  for (v = 0; v < @m; ++v) at[v] = @p > 0 ? pose[v] + zero[v] : 0.0;
  outside = @f_fast(folded, at, q);
  for (v = 0; v < @q; ++v) q[v] += zero[@p + v];
  return outside;
}
)";

std::string fold_code(const std::vector<FoldedNumber>& numbers, const CInputs& inputs) {
  std::string code =
      "int @f_fold(const double *temperatures, double *folded) {\n  int outside = 0;\n"
      "  (void)temperatures;\n";
  code += c_domain_tests(inputs, inputs.pose.size(), inputs.all().size());
  for (std::size_t j = 0; j < numbers.size(); ++j) {
    const std::string place = "  folded[" + std::to_string(j) + "]";
    code += place + " = 0.0; /* q[" + std::to_string(numbers[j].output) + "], " +
            (numbers[j].pose_product.empty() ? "constant" : numbers[j].pose_product) + " */\n";
    for (const auto& term : numbers[j].terms)
      code += place + " += " + c_literal(term.coefficient) +
              (term.product.empty() ? "" : " * (" + term.product + ")") + ";\n";
  }
  // A double holds any set of 31 bits exactly.
  return code + "  folded[" + std::to_string(numbers.size()) +
         "] = outside;\n  return outside;\n}\n";
}

std::string fast_code(const std::vector<FoldedNumber>& numbers, const CInputs& inputs,
                      std::size_t outputs) {
  std::string code =
      "\nint @f_fast(const double *folded, const double *pose, double *q) {\n"
      "  int outside = (int)folded[" +
      std::to_string(numbers.size()) + "];\n  (void)pose;\n";
  code += c_domain_tests(inputs, 0, inputs.pose.size());
  for (std::size_t i = 0; i < outputs; ++i) {
    std::string sum;
    for (std::size_t j = 0; j < numbers.size(); ++j) {
      if (numbers[j].output != i) continue;
      sum += (sum.empty() ? "" : "\n         + ") + ("folded[" + std::to_string(j) + "]") +
             (numbers[j].pose_product.empty() ? "" : " * (" + numbers[j].pose_product + ")");
    }
    code += "  q[" + std::to_string(i) + "] = " + (sum.empty() ? "0.0" : sum) + ";\n";
  }
  return code + "  return outside;\n}\n";
}

}  // namespace

std::string model_c_parts(const calibration::Model& model, const std::string& function,
                          const CInputs& inputs) {
  const auto numbers = folded_numbers(model, inputs);
  std::string code =
      kHead + fold_code(numbers, inputs) + fast_code(numbers, inputs, model.outputs.size()) + kFrom;
  const auto size = inputs.pose.size();
  code = c_replaced(std::move(code), "@c", std::to_string(numbers.size() + 1));
  code = c_replaced(std::move(code), "@m", std::to_string(std::max<std::size_t>(size, 1)));
  code = c_replaced(std::move(code), "@p", std::to_string(size));
  code = c_replaced(std::move(code), "@q", std::to_string(model.outputs.size()));
  return c_replaced(std::move(code), "@f", function);
}

}  // namespace driftwise::formats
