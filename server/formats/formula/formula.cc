#include "server/formats/formula/formula.h"

#include <algorithm>

#include "server/core/data/dataset_parts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/direct_symbols.h"
#include "server/effects/effect.h"
#include "server/effects/term_order.h"
#include "server/formats/formula/formula_lexer.h"
#include "server/formats/formula/formula_tree.h"

namespace driftwise::formats {

struct Formula::Tree {
  std::string text;
  FormulaLimits limits;
  ParsedFormula parsed;
  std::string canonical;
};

Formula::Formula(std::unique_ptr<const Tree> tree) : tree_(std::move(tree)) {}
Formula::Formula(Formula&&) noexcept = default;
Formula& Formula::operator=(Formula&&) noexcept = default;
Formula::~Formula() = default;

const std::string& Formula::canonical() const { return tree_->canonical; }

Result<Formula> Formula::parse(std::string_view text, const FormulaLimits& limits) {
  DRIFTWISE_TRY(auto parsed, parse_formula_text(text, limits));
  auto tree = std::make_unique<Tree>();
  tree->text = text;
  tree->limits = limits;
  tree->canonical = print_formula(parsed);
  tree->parsed = std::move(parsed);
  return Formula(std::move(tree));
}

namespace {

// q, or ma.q: all motor coordinates of robot ma.
bool is_every_motor(const std::string& name) { return without_robot(name) == "q"; }

Result<std::vector<std::string>> outputs_of(const std::vector<FormulaOutput>& named,
                                            const std::vector<Channel>& channels,
                                            std::string_view text) {
  std::vector<std::string> outputs;
  for (const auto& output : named) {
    const std::size_t before = outputs.size();
    for (const auto& channel : channels)
      if (is_every_motor(output.name) ? robot_of(channel.symbol) == robot_of(output.name) &&
                                            is_motor_symbol(without_robot(channel.symbol))
                                      : channel.symbol == output.name)
        outputs.push_back(channel.symbol);
    if (outputs.size() > before) continue;
    return bad_formula(
        text, output.at,
        is_every_motor(output.name)
            ? output.name + " stands for the motor coordinates q1, q2, ... and there are none, " +
                  known_symbols(channels)
            : unknown_symbol(output.name, channels),
        reasons::kUnknownChannel);
  }
  return outputs;
}

// Each effect's parameters in the unit that goes with its channel's. Errors: BAD_UNIT.
Result<effects::Term> in_units_of(const std::vector<Channel>& channels, effects::Term term,
                                  std::string_view text, std::size_t at) {
  for (auto& factor : term.factors) {
    auto* call = std::get_if<effects::Call>(&factor);
    const auto* kind = call == nullptr ? nullptr : effects::find_effect(call->effect);
    if (kind == nullptr || kind->channel_units.empty()) continue;
    for (std::size_t i = 0; i < call->symbols.size(); ++i) {
      const auto channel = std::ranges::find(channels, call->symbols[i], &Channel::symbol);
      if (channel == channels.end()) continue;
      const std::string observed = effects::notation(factor) + " observes " + channel->name();
      if (kind->of_coordinate && i == 0) {
        auto made = effects::for_coordinate_in(channel->unit, *call);
        if (!made)
          return bad_formula(text, at, observed + ": " + made.error().message, reasons::kBadUnit);
        *call = std::move(*made);
        continue;
      }
      const auto& wanted = kind->channel_units[i];
      if (channel->unit != wanted && !(is_length(channel->unit) && is_length(wanted)))
        return bad_formula(text, at, observed + ", expected a channel in " + wanted,
                           reasons::kBadUnit);
    }
  }
  return term;
}

}  // namespace

Result<calibration::Candidates> Formula::expand(
    const std::vector<Channel>& channels,
    const std::vector<std::pair<std::string, std::string>>& parts) const {
  const auto& [text, limits, parsed, canonical] = *tree_;
  calibration::Candidates candidates;
  candidates.formula = canonical;
  DRIFTWISE_TRY(auto outputs, outputs_of(parsed.outputs, channels, text));
  candidates.outputs = std::move(outputs);
  auto sorted = candidates.outputs;
  std::ranges::sort(sorted);
  if (std::ranges::adjacent_find(sorted) != sorted.end())
    return bad_formula(text, parsed.outputs.back().at, "an output stands twice on the left");
  DRIFTWISE_TRY(auto terms, expand_sum(parsed.sum, channels, parts, text, limits));
  candidates.constant = false;
  for (auto& term : terms) {
    if (term.is_constant()) {
      candidates.constant = true;
      continue;
    }
    DRIFTWISE_TRY(auto fitting, in_units_of(channels, std::move(term), text, parsed.sum.at));
    for (const auto& symbol : effects::symbols_read_at_once(fitting))
      if (std::ranges::find(candidates.outputs, symbol) != candidates.outputs.end())
        return bad_formula(text, parsed.sum.at,
                           "the output " + symbol + " stands among its own terms, in " +
                               effects::notation(fitting));
    candidates.terms.push_back(std::move(fitting));
  }
  return candidates;
}

namespace {

std::vector<Channel> channels_of(const Dataset& dataset) {
  std::vector<Channel> channels;
  for (const auto& column : dataset.columns) channels.push_back(column.channel);
  if (!dataset.dwell_s.empty()) channels.push_back({"dwell", "s"});
  return channels;
}

}  // namespace

Result<calibration::Candidates> Formula::expand(const Dataset& dataset) const {
  return expand(channels_of(dataset), parts_from(dataset.metadata));
}

namespace {

using Kind = FormulaNode::Kind;

Result<effects::Factor> factor_of(const FormulaNode& node, std::string_view text) {
  if (node.kind == Kind::name) return effects::Power{node.name, 1};
  if (node.kind == Kind::power) return effects::Power{node.parts.front().name, node.number};
  if (node.kind != Kind::effect)
    return bad_formula(text, node.at, "one term is channels, powers and effects joined by :");
  effects::Call call{node.name, {}, node.quantities};
  for (const auto& part : node.parts) {
    if (part.kind != Kind::name)
      return bad_formula(text, part.at, "expected one channel, not a range");
    call.symbols.push_back(part.name);
  }
  if (call.effect == "datum") {
    const bool whole =
        call.symbols.empty() && call.parameters.size() == 1 && call.parameters[0].unit.empty() &&
        call.parameters[0].value >= 1 && call.parameters[0].value <= 1e9 &&
        call.parameters[0].value == static_cast<double>(static_cast<int>(call.parameters[0].value));
    if (!whole) return bad_formula(text, node.at, "expected datum(k) with a whole number k");
    return call;
  }
  auto checked = effects::checked(call);
  if (!checked) return bad_formula(text, node.at, checked.error().message, checked.error().reason);
  return *checked;
}

}  // namespace

Result<effects::Term> parse_term(std::string_view text) {
  DRIFTWISE_TRY(auto node, parse_term_text(text, {}));
  if (node.kind == FormulaNode::Kind::one) return effects::Term{};
  effects::Term term;
  std::vector<FormulaNode> parts;
  if (node.kind == FormulaNode::Kind::cross)
    parts = std::move(node.parts);
  else
    parts.push_back(std::move(node));
  for (const auto& part : parts) {
    DRIFTWISE_TRY(auto factor, factor_of(part, text));
    term.factors.push_back(std::move(factor));
  }
  return effects::canonical(term);
}

Result<effects::Term> parse_term(std::string_view text, const Dataset& dataset) {
  DRIFTWISE_TRY(auto term, parse_term(text));
  return in_units_of(channels_of(dataset), std::move(term), text, 0);
}

Result<calibration::Model> fit_formula(const Dataset& dataset, std::string_view formula,
                                       calibration::FitOptions options) {
  DRIFTWISE_TRY(auto parsed, Formula::parse(formula));
  DRIFTWISE_TRY(auto candidates, parsed.expand(dataset));
  options.candidates = std::move(candidates);
  return calibration::fit(dataset, options);
}

}  // namespace driftwise::formats
