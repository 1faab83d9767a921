#include "server/effects/term.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <tuple>

#include "server/effects/term_order.h"

namespace driftwise::effects {
namespace {

bool digits_after(const std::string& symbol, char first) {
  return symbol.size() >= 2 && symbol.front() == first &&
         std::all_of(symbol.begin() + 1, symbol.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// pose, motor coordinates, force, structure temperatures, others
int family(const std::string& symbol) {
  static constexpr std::array<const char*, 6> pose = {"x", "y", "z", "rx", "ry", "rz"};
  for (std::size_t i = 0; i < pose.size(); ++i)
    if (symbol == pose[i]) return static_cast<int>(i);
  if (digits_after(symbol, 'q')) return 10;
  if (symbol == "force") return 20;
  if (digits_after(symbol, 't')) return 30;
  return 40;
}

using Key = std::tuple<int, std::size_t, std::string>;

// Numbered symbols sort by number (t2 before t10): shorter first, then by spelling.
Key symbol_key(const std::string& symbol) {
  const int rank = family(symbol);
  return {rank, rank == 40 ? 0 : symbol.size(), symbol};
}

struct Order {
  Key key;
  int is_call;
  std::string text;
  auto operator<=>(const Order&) const = default;
};

Order order_of(const Factor& factor) {
  if (const auto* power = std::get_if<Power>(&factor)) return {symbol_key(power->symbol), 0, {}};
  const auto& call = std::get<Call>(factor);
  const Key key = call.symbols.empty() ? Key{50, 0, {}} : symbol_key(call.symbols.front());
  return {key, 1, notation(factor)};
}

}  // namespace

std::string number_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end.ptr};
}

std::string notation(const Factor& factor) {
  if (const auto* power = std::get_if<Power>(&factor))
    return power->exponent == 1 ? power->symbol
                                : power->symbol + "^" + std::to_string(power->exponent);
  const auto& call = std::get<Call>(factor);
  std::string text = call.effect + "(";
  bool first = true;
  for (const auto& symbol : call.symbols) {
    text += (first ? "" : ", ") + symbol;
    first = false;
  }
  for (const auto& parameter : call.parameters) {
    text += (first ? "" : ", ") + number_text(parameter.value);
    if (!parameter.unit.empty()) text += " " + parameter.unit;
    first = false;
  }
  return text + ")";
}

std::string notation(const Term& term) {
  if (term.is_constant()) return "1";
  std::string text;
  for (const auto& factor : canonical(term).factors) {
    if (!text.empty()) text += ":";
    text += notation(factor);
  }
  return text;
}

Term canonical(const Term& term) {
  Term result;
  for (const auto& factor : term.factors) {
    const auto* power = std::get_if<Power>(&factor);
    Power* merged = nullptr;
    if (power != nullptr)
      for (auto& known : result.factors)
        if (auto* candidate = std::get_if<Power>(&known);
            candidate && candidate->symbol == power->symbol)
          merged = candidate;
    if (merged != nullptr)
      merged->exponent += power->exponent;
    else
      result.factors.push_back(factor);
  }
  if (result.factors.size() > 1)
    std::stable_sort(result.factors.begin(), result.factors.end(),
                     [](const Factor& a, const Factor& b) { return order_of(a) < order_of(b); });
  return result;
}

Term product(const Term& a, const Term& b) {
  Term joined = a;
  joined.factors.insert(joined.factors.end(), b.factors.begin(), b.factors.end());
  return canonical(joined);
}

std::vector<std::string> symbols_of(const Term& term) {
  std::vector<std::string> symbols;
  const auto add = [&symbols](const std::string& symbol) {
    if (std::find(symbols.begin(), symbols.end(), symbol) == symbols.end())
      symbols.push_back(symbol);
  };
  for (const auto& factor : term.factors) {
    if (const auto* power = std::get_if<Power>(&factor))
      add(power->symbol);
    else
      for (const auto& symbol : std::get<Call>(factor).symbols) add(symbol);
  }
  return symbols;
}

Term datum_term(int ordinal) { return {{Call{"datum", {}, {{static_cast<double>(ordinal), ""}}}}}; }

std::optional<int> datum_of(const Term& term) {
  if (term.factors.size() != 1) return std::nullopt;
  const auto* call = std::get_if<Call>(&term.factors.front());
  if (call == nullptr || call->effect != "datum" || call->parameters.size() != 1)
    return std::nullopt;
  return static_cast<int>(call->parameters.front().value);
}

}  // namespace driftwise::effects
