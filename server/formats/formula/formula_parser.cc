#include <cmath>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/effect.h"
#include "server/effects/term_order.h"
#include "server/formats/formula/formula_lexer.h"
#include "server/formats/formula/formula_tree.h"

namespace driftwise::formats {
namespace {

using Kind = FormulaNode::Kind;
using Token = FormulaToken;

// Recursive descent, one method per rule of formula.h. The first error is kept and ends everything.
class Parser {
 public:
  Parser(std::string_view text, std::vector<FormulaLexeme> lexemes, const FormulaLimits& limits)
      : text_(text), lexemes_(std::move(lexemes)), limits_(limits) {}

  Result<ParsedFormula> formula() {
    ParsedFormula parsed;
    do {
      if (!parsed.outputs.empty()) ++next_;
      if (look().token != Token::name)
        return error("expected an output such as q or q1 on the left of ~");
      parsed.outputs.push_back({look().text, look().at});
      ++next_;
    } while (look().token == Token::plus);
    if (look().token != Token::tilde) return error("expected ~ after the output");
    ++next_;
    DRIFTWISE_TRY(auto terms, sum(0));
    if (look().token != Token::end) return error("expected + - * : or the end");
    parsed.sum = std::move(terms);
    return parsed;
  }

  Result<FormulaNode> term() {
    auto node = cross(0);
    if (node && look().token != Token::end) return error("expected : or the end of the term");
    return node;
  }

 private:
  using Parsed = Result<FormulaNode>;

  const FormulaLexeme& look() const { return lexemes_[next_]; }
  tl::unexpected<Error> error(const std::string& expected) const {
    return error_at(look().at, expected);
  }
  tl::unexpected<Error> error_at(std::size_t at, const std::string& what) const {
    const auto& found = look();
    const std::string shown =
        found.token == Token::end ? "the end" : "'" + found.text.substr(0, 40) + "'";
    return bad_formula(text_, at, at == found.at ? "found " + shown + ", " + what : what);
  }

  Parsed sum(int depth) {
    if (depth > limits_.nesting)
      return bad_formula(text_, look().at,
                         "parentheses nest deeper than " + std::to_string(limits_.nesting),
                         reasons::kFormulaTooLarge);
    FormulaNode node;
    node.kind = Kind::sum;
    node.at = look().at;
    char sign = '+';
    if (look().token == Token::minus || look().token == Token::plus) sign = take_sign();
    while (true) {
      auto part = product(depth);
      if (!part) return part;
      node.parts.push_back(std::move(*part));
      node.signs.push_back(sign);
      if (node.parts.size() > limits_.terms)
        return bad_formula(text_, look().at,
                           "more than " + std::to_string(limits_.terms) + " terms",
                           reasons::kFormulaTooLarge);
      if (look().token != Token::plus && look().token != Token::minus) return node;
      sign = take_sign();
    }
  }

  char take_sign() { return lexemes_[next_++].token == Token::minus ? '-' : '+'; }

  Parsed product(int depth) { return joined(depth, Token::star, Kind::star, &Parser::cross); }
  Parsed cross(int depth) { return joined(depth, Token::colon, Kind::cross, &Parser::power); }

  Parsed joined(int depth, Token by, Kind kind, Parsed (Parser::*inner)(int)) {
    auto first = (this->*inner)(depth);
    if (!first || look().token != by) return first;
    FormulaNode node;
    node.kind = kind;
    node.at = first->at;
    node.parts.push_back(std::move(*first));
    while (look().token == by) {
      ++next_;
      auto part = (this->*inner)(depth);
      if (!part) return part;
      node.parts.push_back(std::move(*part));
      if (node.parts.size() > static_cast<std::size_t>(limits_.nesting))
        return bad_formula(text_, look().at,
                           "more than " + std::to_string(limits_.nesting) + " factors",
                           reasons::kFormulaTooLarge);
    }
    return node;
  }

  Parsed power(int depth) {
    auto base = primary(depth);
    if (!base || look().token != Token::power) return base;
    if (base->kind != Kind::name)
      return error_at(base->at,
                      "^ is a power of one channel, such as x^2: write a product as a:b, all "
                      "powers as poly(a, b, 2)");
    ++next_;
    FormulaNode node;
    node.kind = Kind::power;
    node.at = base->at;
    DRIFTWISE_TRY(auto exponent, whole_number("a whole power from 1 to "));
    node.number = exponent;
    node.parts.push_back(std::move(*base));
    if (look().token == Token::power) return error("a power of a power: write one exponent");
    return node;
  }

  Result<int> whole_number(const std::string& what) {
    const double value = look().number;
    if (look().token != Token::number || value != std::floor(value) || value < 1 ||
        value > limits_.degree)
      return error("expected " + what + std::to_string(limits_.degree));
    ++next_;
    return static_cast<int>(value);
  }

  Parsed primary(int depth) {
    FormulaNode node;
    node.at = look().at;
    switch (look().token) {
      case Token::number:
        if (look().number != 1) return error("the only number that is a term is 1, the constant");
        ++next_;
        return node;
      case Token::open: {
        ++next_;
        auto inner = sum(depth + 1);
        if (!inner) return inner;
        if (look().token != Token::close) return error("expected ) or + - * :");
        ++next_;
        inner->parenthesised = true;
        return inner;
      }
      case Token::name:
        break;
      default:
        return error("expected a channel, 1, ( or an effect");
    }
    node = channel();
    if (look().token == Token::range) {
      DRIFTWISE_RETURN_IF_ERROR(range(node));
    } else if (look().token == Token::open) {
      ++next_;
      return node.name == "poly" ? poly(std::move(node)) : effect(std::move(node));
    }
    return node;
  }

  FormulaNode channel() {
    FormulaNode node;
    node.kind = Kind::name;
    node.at = look().at;
    node.name = lexemes_[next_++].text;
    return node;
  }

  // At the ".." after a channel.
  Result<void> range(FormulaNode& node) {
    ++next_;
    if (look().token != Token::name)
      return error("expected the last channel of the range, as in t05..t10");
    node.kind = Kind::range;
    node.name_to = lexemes_[next_++].text;
    return {};
  }

  // After "poly(".
  Parsed poly(FormulaNode node) {
    node.kind = Kind::poly;
    while (look().token == Token::name) {
      node.parts.push_back(channel());
      if (look().token != Token::comma)
        return error("expected , and then more channels or the degree of poly");
      ++next_;
    }
    if (node.parts.empty()) return error("expected a channel: poly(x, y, z, 3)");
    DRIFTWISE_TRY(auto degree, whole_number("the degree of poly, a whole number from 1 to "));
    node.number = degree;
    if (look().token != Token::close) return error("expected ) after the degree of poly");
    ++next_;
    return node;
  }

  // After "rate(": channels, then quantities. What they must be is the registry's to say, at
  // expansion.
  Parsed effect(FormulaNode node) {
    node.kind = Kind::effect;
    if (look().token == Token::close) {
      ++next_;
      return node;
    }
    while (true) {
      const bool minus = look().token == Token::minus;
      if (minus) ++next_;
      if (look().token == Token::number) {
        effects::Quantity quantity{minus ? -look().number : look().number, ""};
        ++next_;
        if (look().token == Token::name) quantity.unit = lexemes_[next_++].text;
        node.quantities.push_back(std::move(quantity));
      } else if (look().token == Token::name && !minus && node.quantities.empty()) {
        if (lexemes_[next_ + 1].token == Token::open)
          return error("an effect observes channels, not other effects");
        node.parts.push_back(channel());
        if (look().token == Token::range) DRIFTWISE_RETURN_IF_ERROR(range(node.parts.back()));
      } else {
        return error("expected a channel or a quantity such as 300 s in " + node.name + "(...)");
      }
      if (node.parts.size() + node.quantities.size() > 16) return error("too many arguments");
      if (look().token == Token::close) break;
      if (look().token != Token::comma) return error("expected , or ) in " + node.name + "(...)");
      ++next_;
    }
    ++next_;
    return node;
  }

  std::string_view text_;
  std::vector<FormulaLexeme> lexemes_;
  FormulaLimits limits_;
  std::size_t next_ = 0;
};

Result<Parser> parser_for(std::string_view text, const FormulaLimits& limits) {
  if (text.size() > limits.text_bytes)
    return fail(ErrorCode::invalid_argument, reasons::kFormulaTooLarge,
                "formula: " + std::to_string(text.size()) + " bytes long, at most " +
                    std::to_string(limits.text_bytes) + " are read");
  DRIFTWISE_TRY(auto lexemes, lex_formula(text));
  return Parser(text, std::move(lexemes), limits);
}

}  // namespace

Result<ParsedFormula> parse_formula_text(std::string_view text, const FormulaLimits& limits) {
  DRIFTWISE_TRY(auto parser, parser_for(text, limits));
  return parser.formula();
}

Result<FormulaNode> parse_term_text(std::string_view text, const FormulaLimits& limits) {
  DRIFTWISE_TRY(auto parser, parser_for(text, limits));
  return parser.term();
}

}  // namespace driftwise::formats
