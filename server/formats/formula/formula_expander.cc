#include <algorithm>
#include <unordered_map>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/effect.h"
#include "server/effects/term_order.h"
#include "server/formats/formula/formula_lexer.h"
#include "server/formats/formula/formula_tree.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

using effects::Term;
using Kind = FormulaNode::Kind;

Term plain(const std::string& symbol, int exponent = 1) {
  return {{effects::Power{symbol, exponent}}};
}

// "t05" -> ("t", 5, width 2); width 0 when it does not end in digits.
struct Numbered {
  std::string stem;
  long number = 0;
  std::size_t width = 0;
};
Numbered numbered(const std::string& name) {
  std::size_t start = name.size();
  while (start > 0 && name[start - 1] >= '0' && name[start - 1] <= '9') --start;
  if (start == name.size() || name.size() - start > 6) return {};
  return {name.substr(0, start), std::stol(name.substr(start)), name.size() - start};
}

class Expander {
 public:
  Expander(const std::vector<Channel>& channels,
           const std::vector<std::pair<std::string, std::string>>& parts, std::string_view text,
           const FormulaLimits& limits)
      : channels_(channels), parts_(parts), text_(text), limits_(limits) {}

  using Terms = Result<std::vector<Term>>;

  // constant: the constant is there before the first term is read.
  Terms sum(const FormulaNode& node, bool constant) {
    std::vector<Term> terms;
    std::unordered_map<std::string, bool> present;  // ever seen -> still in
    const auto add = [&](Term term) {
      auto& in = present[effects::notation(term)];
      if (!in) terms.push_back(std::move(term));
      in = true;
    };
    if (constant) add({});
    for (std::size_t i = 0; i < node.parts.size(); ++i) {
      auto part = expand(node.parts[i]);
      if (!part) return part;
      if (node.signs[i] == '+') {
        for (auto& term : *part) add(std::move(term));
        if (terms.size() > limits_.terms + 1) return too_large(node.parts[i].at);
        continue;
      }
      for (const auto& term : *part) {
        const std::string name = effects::notation(term);
        auto at = present.find(name);
        if (at == present.end() || !at->second)
          return bad_formula(text_, node.parts[i].at,
                             "nothing to remove: " + name + " does not stand before this");
        at->second = false;
      }
      std::erase_if(terms,
                    [&present](const Term& term) { return !present.at(effects::notation(term)); });
    }
    return terms;
  }

 private:
  tl::unexpected<Error> too_large(std::size_t at) const {
    return bad_formula(
        text_, at, "the formula expands to more than " + std::to_string(limits_.terms) + " terms",
        reasons::kFormulaTooLarge);
  }

  Terms expand(const FormulaNode& node) {
    auto terms = expand_one(node);
    // Repeated large parts must not take minutes: every term made counts, kept or not.
    if (terms && (made_ += terms->size()) > 50 * limits_.terms) return too_large(node.at);
    return terms;
  }

  Terms expand_one(const FormulaNode& node) {
    switch (node.kind) {
      case Kind::one:
        return std::vector<Term>{Term{}};
      case Kind::name:
      case Kind::range: {
        DRIFTWISE_TRY(auto symbols, channels_of(node));
        std::vector<Term> terms;
        for (const auto& symbol : symbols) terms.push_back(plain(symbol));
        return terms;
      }
      case Kind::power: {
        DRIFTWISE_TRY(auto symbols, channels_of(node.parts.front()));
        if (symbols.size() != 1)
          return bad_formula(
              text_, node.at,
              node.parts.front().name + " is several channels here: write the power of each");
        return std::vector<Term>{plain(symbols.front(), node.number)};
      }
      case Kind::poly:
        return poly(node);
      case Kind::effect:
        return effect(node);
      case Kind::sum:
        return sum(node, false);
      case Kind::cross:
      case Kind::star:
        return joined(node);
    }
    return std::vector<Term>{};
  }

  Terms joined(const FormulaNode& node) {
    auto terms = expand(node.parts.front());
    for (std::size_t i = 1; terms && i < node.parts.size(); ++i) {
      auto right = expand(node.parts[i]);
      if (!right) return right;
      if (terms->size() * right->size() > limits_.terms) return too_large(node.at);
      std::vector<Term> result;
      if (node.kind == Kind::star) {
        result = *terms;
        result.insert(result.end(), right->begin(), right->end());
      }
      for (const auto& a : *terms) {
        for (const auto& b : *right) {
          result.push_back(effects::product(a, b));
          for (const auto& factor : result.back().factors)
            if (const auto* power = std::get_if<effects::Power>(&factor);
                power && power->exponent > limits_.degree)
              return bad_formula(text_, node.at,
                                 "the product holds " + effects::notation(factor) +
                                     ", powers go up to " + std::to_string(limits_.degree));
        }
      }
      terms = std::move(result);
    }
    return terms;
  }

  Terms poly(const FormulaNode& node) {
    std::vector<std::string> symbols;
    for (const auto& part : node.parts) {
      DRIFTWISE_TRY(auto some, channels_of(part));
      for (const auto& symbol : some) {
        if (std::ranges::find(symbols, symbol) != symbols.end())
          return bad_formula(text_, part.at, symbol + " stands twice in poly");
        symbols.push_back(symbol);
      }
    }
    double count = 1;  // of monomials, the constant included: (variables + degree choose degree)
    for (int i = 1; i <= node.number; ++i) count *= (static_cast<double>(symbols.size()) + i) / i;
    if (count - 1 > static_cast<double>(limits_.terms)) return too_large(node.at);
    std::vector<Term> terms;
    std::vector<int> exponents(symbols.size());
    for (int degree = 1; degree <= node.number; ++degree)
      monomials(symbols, exponents, 0, degree, terms);
    return terms;
  }

  // All monomials of exactly the degree that is left, the first symbols' powers falling: x^2, x:y,
  // x:z, y^2, ...
  static void monomials(const std::vector<std::string>& symbols, std::vector<int>& exponents,
                        std::size_t from, int left, std::vector<Term>& terms) {
    if (from + 1 == symbols.size()) {
      exponents[from] = left;
      Term term;
      for (std::size_t i = 0; i < symbols.size(); ++i)
        if (exponents[i] > 0) term.factors.emplace_back(effects::Power{symbols[i], exponents[i]});
      terms.push_back(effects::canonical(term));
      exponents[from] = 0;
      return;
    }
    for (int take = left; take >= 0; --take) {
      exponents[from] = take;
      monomials(symbols, exponents, from + 1, left - take, terms);
    }
    exponents[from] = 0;
  }

  Terms effect(const FormulaNode& node) {
    if (node.name == "datum")
      return bad_formula(text_, node.at, "constants of further datums are added by the fit itself");
    std::vector<std::vector<std::string>> arguments;
    std::size_t count = 1;
    for (const auto& part : node.parts) {
      DRIFTWISE_TRY(auto symbols, channels_of(part));
      count *= symbols.size();
      if (count > limits_.terms) return too_large(node.at);
      arguments.push_back(std::move(symbols));
    }
    std::vector<Term> terms;
    for (std::size_t index = 0; index < count; ++index) {
      effects::Call call{node.name, {}, node.quantities};
      std::size_t rest = index;
      for (auto argument = arguments.rbegin(); argument != arguments.rend(); ++argument) {
        call.symbols.insert(call.symbols.begin(), (*argument)[rest % argument->size()]);
        rest /= argument->size();
      }
      auto checked = effects::checked(call);
      if (!checked)
        return bad_formula(text_, node.at, checked.error().message, checked.error().reason);
      terms.push_back({{std::move(*checked)}});
    }
    return terms;
  }

  bool has(const std::string& symbol) const {
    return std::ranges::any_of(
        channels_, [&symbol](const Channel& channel) { return channel.symbol == symbol; });
  }

  tl::unexpected<Error> unknown(std::size_t at, const std::string& what) const {
    return bad_formula(text_, at, what, reasons::kUnknownChannel);
  }

  // The channels a name or range stands for.
  Result<std::vector<std::string>> channels_of(const FormulaNode& node) const {
    std::vector<std::string> symbols;
    if (node.kind == Kind::range) return range(node);
    if (node.name == "T") {
      for (const auto& channel : channels_)
        if (is_structure_temperature(channel)) symbols.push_back(channel.symbol);
      if (symbols.empty())
        return unknown(
            node.at,
            "T stands for the structure temperatures (channels in degC or K, such as t07_degC) and "
            "there are none, " +
                known_symbols(channels_));
      return symbols;
    }
    if (node.name == "R" && !has("R")) {
      for (const auto& channel : channels_)
        if (std::ranges::find(parts_, std::pair(channel.symbol, std::string("robot"))) !=
            parts_.end())
          symbols.push_back(channel.symbol);
      if (symbols.empty())
        return unknown(
            node.at, parts_.empty()
                         ? "R stands for the thermometers on the robot, and these data do not say "
                           "which they are: name them, or add a line '# parts: t05=robot "
                           "t01=instrument' at the head of the file, " +
                               known_symbols(channels_)
                         : "R stands for the thermometers on the robot, and the cell file declares "
                           "none of these channels with part = \"robot\", " +
                               known_symbols(channels_));
      return symbols;
    }
    const std::string symbol = node.name == "F" ? "force" : node.name;
    if (!has(symbol))
      return unknown(node.at, node.name == "F" ? "F stands for force and there is none, " +
                                                     known_symbols(channels_)
                                               : unknown_symbol(symbol, channels_));
    symbols.push_back(symbol);
    return symbols;
  }

  Result<std::vector<std::string>> range(const FormulaNode& node) const {
    const Numbered from = numbered(node.name), to = numbered(node.name_to);
    if (from.width == 0 || from.stem != to.stem || from.number > to.number)
      return bad_formula(
          text_, node.at,
          "a range runs from one number to a higher one of the same name, as t05..t10");
    std::vector<std::string> symbols;
    if (!has(node.name)) return unknown(node.at, unknown_symbol(node.name, channels_));
    if (!has(node.name_to)) return unknown(node.at, unknown_symbol(node.name_to, channels_));
    for (const auto& channel : channels_) {
      const Numbered one = numbered(channel.symbol);
      if (one.width > 0 && one.stem == from.stem && one.number >= from.number &&
          one.number <= to.number)
        symbols.push_back(channel.symbol);
    }
    std::ranges::sort(symbols, {},
                      [](const std::string& symbol) { return numbered(symbol).number; });
    return symbols;
  }

  const std::vector<Channel>& channels_;
  const std::vector<std::pair<std::string, std::string>>& parts_;
  std::string_view text_;
  FormulaLimits limits_;
  std::size_t made_ = 0;
};

}  // namespace

std::string known_symbols(const std::vector<Channel>& channels) {
  std::string known;
  std::size_t shown = 0;
  for (const auto& channel : channels) {
    if (++shown > 40) return "the file has:" + known + " ...";
    known += " " + channel.symbol;
  }
  return known.empty() ? "the file has no channels" : "the file has:" + known;
}

std::string unknown_symbol(const std::string& symbol, const std::vector<Channel>& channels) {
  std::vector<std::string_view> known;
  for (const auto& channel : channels) known.emplace_back(channel.symbol);
  const std::string shown = symbol.substr(0, 60), nearest = nearest_word(shown, known);
  return "unknown channel '" + shown + "'" +
         (nearest.empty() ? ", " : ": did you mean " + nearest + "? ") + known_symbols(channels);
}

Result<std::vector<Term>> expand_sum(const FormulaNode& sum, const std::vector<Channel>& channels,
                                     const std::vector<std::pair<std::string, std::string>>& parts,
                                     std::string_view text, const FormulaLimits& limits) {
  return Expander(channels, parts, text, limits).sum(sum, true);
}

}  // namespace driftwise::formats
