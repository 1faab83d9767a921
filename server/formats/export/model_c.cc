#include "server/formats/export/model_c.h"

#include <algorithm>
#include <cctype>
#include <set>

#include "server/compensation/snapshot.h"
#include "server/core/channel.h"
#include "server/core/data/reading.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/effect.h"
#include "server/effects/term_evaluator.h"
#include "server/effects/term_order.h"
#include "server/formats/export/model_c_parts.h"
#include "server/formats/export/model_c_text.h"
#include "server/formats/text/text.h"
#include "server/plans/robot_parts.h"

namespace driftwise::formats {
namespace {

constexpr std::size_t kTestVectors = 24;

tl::unexpected<Error> not_exportable(const effects::Term& term, const std::string& why) {
  return fail(ErrorCode::failed_precondition, reasons::kNotExportable,
              "term " + effects::notation(term) + " " + why);
}

Result<CInputs> collect_inputs(const calibration::Model& model) {
  CInputs inputs;
  for (const auto& range : model.domain)
    (compensation::variable_from(range.channel.symbol) ? inputs.pose : inputs.slow)
        .push_back(range);
  for (const auto& output : model.outputs)
    for (const auto& term : output.terms) {
      if (effects::datum_of(term)) continue;
      for (const auto& factor : term.factors)
        if (const auto* call = std::get_if<effects::Call>(&factor)) {
          const auto* kind = effects::find_effect(call->effect);
          return not_exportable(
              term, kind != nullptr && kind->memoryless
                        ? "needs a function of the C library, whose last digits differ from one "
                          "to another: the exported file has to give the same on every controller"
                        : "has a memory: it is no function of the present values");
        }
      for (const auto& symbol : effects::symbols_of(term))
        if (inputs.expression(symbol).empty())
          return not_exportable(
              term, "reads " + symbol + ", and the model does not say the range it was fitted in");
    }
  return inputs;
}

std::string term_expression(const effects::Term& term, const CInputs& inputs) {
  std::string out;
  const effects::Term ordered = effects::canonical(term);
  for (const auto& factor : ordered.factors) {
    const auto& power = std::get<effects::Power>(factor);
    out += (out.empty() ? "" : " * ") + c_power(inputs.expression(power.symbol), power.exponent);
  }
  return out;
}

std::string output_code(const calibration::OutputModel& output, std::size_t index,
                        const CInputs& inputs) {
  std::string code = "  {\n    double sum = 0.0; /* " + output.channel.name() + " */\n";
  for (std::size_t k = 0; k < output.terms.size(); ++k) {
    if (effects::datum_of(output.terms[k])) continue;
    const std::string value = c_literal(output.coefficients[static_cast<Eigen::Index>(k)]);
    const std::string product = term_expression(output.terms[k], inputs);
    code += "    sum += " + value + (product.empty() ? "" : " * (" + product + ")") + ";\n";
  }
  return code + "    q[" + std::to_string(index) + "] = sum;\n  }\n";
}

// A point of the domain: coordinate i of vector v, spread by a fixed low-discrepancy rule (additive
// recurrence), the first vectors being the two ends and the middle.
double test_value(const calibration::ChannelRange& range, std::size_t i, std::size_t v) {
  if (v == 0) return range.min;
  if (v == 1) return range.max;
  double share = v == 2 ? 0.5
                        : static_cast<double>(v) * 0.6180339887498949 +
                              static_cast<double>(i) * 0.4142135623730951;
  share -= static_cast<double>(static_cast<long long>(share));
  return std::clamp(range.min + share * (range.max - range.min), range.min, range.max);
}

// As the C function sums: term by term, constant first where the model has it first.
double reference(const calibration::OutputModel& output, const std::vector<std::string>& symbols,
                 const std::vector<double>& values) {
  std::vector<effects::Term> terms;
  std::vector<double> coefficients;
  for (std::size_t k = 0; k < output.terms.size(); ++k) {
    if (effects::datum_of(output.terms[k])) continue;
    terms.push_back(output.terms[k]);
    coefficients.push_back(output.coefficients[static_cast<Eigen::Index>(k)]);
  }
  const auto evaluator = effects::TermEvaluator::create(terms, symbols);
  if (!evaluator) return kMissing;
  std::vector<double> columns(terms.size());
  evaluator->evaluate(values, columns);
  double sum = 0.0;
  for (std::size_t k = 0; k < terms.size(); ++k) sum += coefficients[k] * columns[k];
  return sum;
}

std::string vector_table(const calibration::Model& model, const CInputs& inputs) {
  const auto ranges = inputs.all();
  std::vector<std::string> symbols;
  for (const auto& range : ranges) symbols.push_back(range.channel.symbol);
  std::string table;
  for (std::size_t v = 0; v < kTestVectors; ++v) {
    std::vector<double> values;
    for (std::size_t i = 0; i < ranges.size(); ++i) values.push_back(test_value(ranges[i], i, v));
    std::string row;
    for (const double value : values) row += c_literal(value) + ", ";
    for (const auto& output : model.outputs)
      row += c_literal(reference(output, symbols, values)) + ", ";
    row.resize(row.size() - 2);
    table += "  {" + row + "},\n";
  }
  return table;
}

std::string list_of(const std::vector<calibration::ChannelRange>& ranges) {
  std::string out;
  for (const auto& range : ranges) out += (out.empty() ? "" : ", ") + range.channel.name();
  return out.empty() ? "none" : out;
}

// Nothing that a person typed may end the comment it stands in.
std::string comment_safe(std::string text) {
  for (char& c : text)
    if (c == '*' || c == '\\' || c == '\n' || c == '\r' || static_cast<unsigned char>(c) >= 0x7f)
      c = '.';
  return text;
}

// "no id, ma": ids as a message lists them.
std::string ids_of(const std::set<std::string>& robots) {
  std::string out;
  for (const auto& id : robots) out += (out.empty() ? "" : ", ") + (id.empty() ? "no id" : id);
  return out;
}

// robot: its id, which the names do not have; empty: none.
std::string head_comment(const calibration::Model& model, const std::string& robot,
                         const std::string& function, const CInputs& inputs) {
  std::string outputs;
  for (const auto& output : model.outputs)
    outputs += (outputs.empty() ? "" : ", ") + output.channel.name();
  return "/* Motor coordinates for a wanted pose, a Driftwise model as plain C99.\n"
         " * formula: " +
         comment_safe(model.formula) +
         "\n"
         " * source: " +
         comment_safe(model.lineage.source) + ", " +
         std::to_string(model.lineage.rows_calibration) + " calibration rows\n" +
         (robot.empty() ? "" : " * robot: " + comment_safe(robot) + "\n") +
         " *\n"
         " * pose: " +
         list_of(inputs.pose) +
         "\n"
         " * temperatures: " +
         list_of(inputs.slow) +
         "\n"
         " * q: " +
         outputs +
         "\n"
         " * Returned: 0, or a bit per input outside the fitted domain (0.5 % of its width on each "
         "side is\n * still inside, as in the daemon), in the order above, pose first; q is given "
         "either way.\n"
         " *\n"
         " * Compile without contraction of a * b + c (-std=c99, or -ffp-contract=off): then q is "
         "that of the\n * model's formula, term by term in its order, to the last bit. The "
         "daemon's "
         "target differs from it by\n * rounding: the daemon sums temperatures and pose in two "
         "steps, "
         "in another order.\n"
         " * Self test: cc -std=c99 -DDRIFTWISE_MODEL_SELF_TEST this_file.c && ./a.out\n"
         " */\n"
         "int " +
         function + "(const double *pose, const double *temperatures, double *q);\n\n";
}

// Newton's method of calibration::pose_of_zero, as plain C; @n axes.
constexpr const char* kPoseOfZero = R"(  {
    static const int axis[@n] = {@axes};
    static const double range[@n] = {@ranges};
    double shift[@n] = {0.0}, left[@q], side[@q], a[@n][@n + 1];
    int turn, i, j, k, found = 0, lost = 0;
    for (turn = 0; turn < 8 && !found && !lost; ++turn) {
      double largest = 0.0;
      for (i = 0; i < @n; ++i) at[axis[i]] = pose[axis[i]] + shift[i];
      (void)@f(at, temperatures, left);
      for (j = 0; j < @n; ++j) {
        const double step = 1e-4 * range[j], here = at[axis[j]];
        at[axis[j]] = here + step;
        (void)@f(at, temperatures, side);
        for (i = 0; i < @n; ++i) a[i][j] = side[i];
        at[axis[j]] = here - step;
        (void)@f(at, temperatures, side);
        for (i = 0; i < @n; ++i) a[i][j] = (a[i][j] - side[i]) / (2.0 * step);
        at[axis[j]] = here;
      }
      for (i = 0; i < @n; ++i) a[i][@n] = q[i] - left[i];
      for (j = 0; j < @n; ++j) { /* elimination with the largest pivot */
        int best = j;
        for (i = j + 1; i < @n; ++i)
          if (a[i][j] * a[i][j] > a[best][j] * a[best][j]) best = i;
        for (k = 0; k <= @n; ++k) {
          const double swap = a[j][k];
          a[j][k] = a[best][k];
          a[best][k] = swap;
        }
        if (!(a[j][j] * a[j][j] > 0.0)) lost = 1;
        for (i = 0; i < @n && !lost; ++i) {
          const double share = i == j ? 0.0 : a[i][j] / a[j][j];
          for (k = j; k <= @n; ++k) a[i][k] -= share * a[j][k];
        }
      }
      for (i = 0; i < @n && !lost; ++i) {
        const double by = a[i][@n] / a[i][i];
        shift[i] += by;
        if (!(shift[i] * shift[i] < 4e-4 * range[i] * range[i])) lost = 1;
        if (by * by > largest * range[i] * range[i]) largest = by * by / (range[i] * range[i]);
      }
      if (!lost && largest < 1e-20) found = 1;
    }
    for (i = 0; i < @n && found; ++i) zero[axis[i]] = shift[i];
    moved = found;
  }
)";

// The zero of another datum: where it lies in the model's own, and targets from there.
std::string datum_code(const calibration::Model& model, const std::string& function,
                       const CInputs& inputs) {
  std::string axes, ranges;
  std::size_t count = 0;
  bool ranged = true;
  for (std::size_t i = 0; i < inputs.pose.size(); ++i) {
    if (!is_length(inputs.pose[i].channel.unit)) continue;
    const double range = inputs.pose[i].max - inputs.pose[i].min;
    ranged = ranged && range > 0;
    axes += (count == 0 ? "" : ", ") + std::to_string(i);
    ranges += (count++ == 0 ? "" : ", ") + c_literal(range);
  }
  const bool solvable = ranged && count > 0 && count == model.outputs.size();
  std::string code =
      "\n/* After another zeroing. zero: room for @p + @q doubles, filled by @f_zero, read by\n"
      " * @f_from. pose: of that zero, all 0 but a force; temperatures: those at that instant; q: "
      "what the\n * motors read there. Returned: 1 when the zero's place in the model's own datum "
      "was found, 0 when it was not\n * and q differs by a constant only. */\n"
      "int @f_zero(const double *pose, const double *temperatures, const double *q, double "
      "*zero);\n"
      "int @f_from(const double *zero, const double *pose, const double *temperatures, double "
      "*q);\n\n"
      "int @f_zero(const double *pose, const double *temperatures, const double *q, double *zero) "
      "{\n"
      "  double at[@m], there[@q];\n  int v, moved = 0;\n"
      "  for (v = 0; v < @p + @q; ++v) zero[v] = 0.0;\n"
      "  for (v = 0; v < @m; ++v) at[v] = @p > 0 ? pose[v] : 0.0;\n";
  if (solvable) code += kPoseOfZero;
  code +=
      "  for (v = 0; v < @m; ++v) at[v] = @p > 0 ? pose[v] + zero[v] : 0.0;\n"
      "  (void)@f(at, temperatures, there);\n"
      "  for (v = 0; v < @q; ++v) zero[@p + v] = q[v] - there[v];\n"
      "  return moved;\n}\n\n"
      "int @f_from(const double *zero, const double *pose, const double *temperatures, double *q) "
      "{\n"
      "  double at[@m];\n  int v, outside;\n"
      "  for (v = 0; v < @m; ++v) at[v] = @p > 0 ? pose[v] + zero[v] : 0.0;\n"
      "  outside = @f(at, temperatures, q);\n"
      "  for (v = 0; v < @q; ++v) q[v] += zero[@p + v];\n"
      "  return outside;\n}\n";
  const auto size = inputs.pose.size();
  code = c_replaced(std::move(code), "@axes", axes);
  code = c_replaced(std::move(code), "@ranges", ranges);
  code = c_replaced(std::move(code), "@n", std::to_string(count));
  code = c_replaced(std::move(code), "@p", std::to_string(size));
  code = c_replaced(std::move(code), "@m", std::to_string(std::max<std::size_t>(size, 1)));
  code = c_replaced(std::move(code), "@q", std::to_string(model.outputs.size()));
  return c_replaced(std::move(code), "@f", function);
}

std::string self_test(const calibration::Model& model, const std::string& function,
                      const CInputs& inputs) {
  const std::string in = std::to_string(inputs.pose.size() + inputs.slow.size()),
                    fast = std::to_string(inputs.pose.size());
  const std::string out = std::to_string(model.outputs.size());
  return "\n#ifdef DRIFTWISE_MODEL_SELF_TEST\n#include <stdio.h>\n\n"
         "/* pose, temperatures, then the q expected. */\n"
         "static const double vectors[" +
         std::to_string(kTestVectors) + "][" + in + " + " + out + "] = {\n" +
         vector_table(model, inputs) +
         "};\n\n"
         "int main(void) {\n"
         "  int failures = 0;\n"
         "  for (int v = 0; v < " +
         std::to_string(kTestVectors) +
         "; ++v) {\n"
         "    double q[" +
         out +
         "];\n"
         "    const int outside = " +
         function + "(vectors[v], vectors[v] + " + fast +
         ", q);\n"
         "    double folded[" +
         function + "_folded], fast[" + out +
         "];\n"
         "    (void)" +
         function + "_fold(vectors[v] + " + fast +
         ", folded);\n"
         "    (void)" +
         function +
         "_fast(folded, vectors[v], fast);\n"
         "    for (int i = 0; i < " +
         out +
         "; ++i) {\n"
         "      const double apart = fast[i] - q[i];\n"
         "      if (!(apart * apart <= 1e-18 * (1.0 + q[i] * q[i]))) {\n"
         "        ++failures;\n"
         "        printf(\"vector %d output %d: two parts give %.17g, one gives %.17g\\n\", v, i, "
         "fast[i], q[i]);\n"
         "      }\n"
         "      if (q[i] != vectors[v][" +
         in +
         " + i] || outside != 0) {\n"
         "        ++failures;\n"
         "        printf(\"vector %d output %d: found %.17g, expected %.17g, outside %d\\n\", v, "
         "i, q[i], vectors[v][" +
         in +
         " + i], outside);\n"
         "      }\n    }\n  }\n"
         "  printf(\"%d of " +
         std::to_string(kTestVectors * model.outputs.size()) +
         " values differ\\n\", failures);\n"
         "  return failures == 0 ? 0 : 1;\n}\n#endif\n";
}

}  // namespace

Result<std::string> write_model_c(const calibration::Model& stored, const std::string& name) {
  const bool good_name =
      !name.empty() && name.size() <= 64 && std::ranges::all_of(name, [](unsigned char c) {
        return c < 0x80 && (std::isalnum(c) || c == '_');
      });
  if (!good_name)
    return fail(ErrorCode::invalid_argument, reasons::kBadName,
                "found the name " + shown(name) + ", expected letters, digits and '_', at most 64");
  // A robot with an id: "ma.x" is its pose, as "x" of a robot without one.
  const auto robots = plans::robots_of(stored);
  const std::string robot = robots.empty() ? "" : *robots.begin();
  if (robots.size() > 1)
    return fail(ErrorCode::failed_precondition, reasons::kNotExportable,
                "the model has channels of several robots (" + ids_of(robots) +
                    "): a C function has the pose of one; fit each robot for itself");
  DRIFTWISE_TRY(const auto model, plans::part_of_robot(stored, robot));
  DRIFTWISE_TRY(const auto inputs, collect_inputs(model));
  const auto ranges = inputs.all();
  if (ranges.size() > 31)
    return fail(ErrorCode::failed_precondition, reasons::kNotExportable,
                "the model reads " + std::to_string(ranges.size()) +
                    " channels, at most 31 have a bit in the answer");
  const std::string function = "driftwise_model_" + name;
  std::string code = head_comment(model, robot, function, inputs);
  code += "int " + function +
          "(const double *pose, const double *temperatures, double *q) {\n  int outside = 0;\n  "
          "(void)pose;\n  (void)temperatures;\n";
  code += c_domain_tests(inputs, 0, ranges.size());
  for (std::size_t i = 0; i < model.outputs.size(); ++i)
    code += output_code(model.outputs[i], i, inputs);
  return code + "  return outside;\n}\n" + datum_code(model, function, inputs) +
         model_c_parts(model, function, inputs) + self_test(model, function, inputs);
}

}  // namespace driftwise::formats
