#include "server/formats/formula/formula_lexer.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace driftwise::formats {
namespace {

constexpr std::size_t kWindow = 60;  // bytes shown on either side of the place

bool letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool digit(char c) { return c >= '0' && c <= '9'; }
bool printable(char c) { return c >= ' ' && c <= '~'; }

FormulaToken single(char c) {
  switch (c) {
    case '~':
      return FormulaToken::tilde;
    case '+':
      return FormulaToken::plus;
    case '-':
      return FormulaToken::minus;
    case '*':
      return FormulaToken::star;
    case ':':
      return FormulaToken::colon;
    case '^':
      return FormulaToken::power;
    case '(':
      return FormulaToken::open;
    case ')':
      return FormulaToken::close;
    case ',':
      return FormulaToken::comma;
    default:
      return FormulaToken::end;
  }
}

std::size_t name_end(std::string_view text, std::size_t at) {
  while (at < text.size() && (letter(text[at]) || digit(text[at]) || text[at] == '_')) ++at;
  return at;
}

// Where a number that starts at `at` ends: digits, at most one point (never the ".." of a range),
// an exponent.
std::size_t number_end(std::string_view text, std::size_t at) {
  std::size_t end = at;
  while (end < text.size() && digit(text[end])) ++end;
  if (end < text.size() && text[end] == '.' && !(end + 1 < text.size() && text[end + 1] == '.')) {
    ++end;
    while (end < text.size() && digit(text[end])) ++end;
  }
  if (end < text.size() && (text[end] == 'e' || text[end] == 'E')) {
    std::size_t exponent = end + 1;
    if (exponent < text.size() && (text[exponent] == '+' || text[exponent] == '-')) ++exponent;
    if (exponent < text.size() && digit(text[exponent])) {
      end = exponent;
      while (end < text.size() && digit(text[end])) ++end;
    }
  }
  return end;
}

}  // namespace

std::string point_at(std::string_view text, std::size_t at, const std::string& what) {
  at = std::min(at, text.size());
  const std::size_t begin = at > kWindow ? at - kWindow : 0;
  std::string shown(text.substr(begin, 2 * kWindow));
  std::ranges::replace_if(
      shown, [](char c) { return !printable(c); }, '?');
  const bool cut_front = begin > 0, cut_back = begin + 2 * kWindow < text.size();
  return what + ", column " + std::to_string(at + 1) + ":\n  " + (cut_front ? "..." : "") + shown +
         (cut_back ? "..." : "") + "\n  " + std::string(at - begin + (cut_front ? 3 : 0), ' ') +
         "^";
}

tl::unexpected<Error> bad_formula(std::string_view text, std::size_t at, const std::string& what,
                                  std::string reason) {
  return fail(ErrorCode::invalid_argument, std::move(reason),
              "formula: " + point_at(text, at, what));
}

Result<std::vector<FormulaLexeme>> lex_formula(std::string_view text) {
  std::vector<FormulaLexeme> lexemes;
  std::size_t at = 0;
  while (at < text.size()) {
    const char c = text[at];
    if (c == ' ' || c == '\t' || c == '\n' || c == '\r') {
      ++at;
      continue;
    }
    FormulaLexeme lexeme;
    lexeme.at = at;
    std::size_t end = at + 1;
    if (letter(c)) {
      end = name_end(text, end);
      // A robot's id before its channel: ma.q1. The ".." of a range is none.
      if (end + 1 < text.size() && text[end] == '.' && letter(text[end + 1]))
        end = name_end(text, end + 1);
      lexeme.token = FormulaToken::name;
    } else if (digit(c) || (c == '.' && end < text.size() && digit(text[end]))) {
      end = number_end(text, at);
      lexeme.token = FormulaToken::number;
      const auto read = std::from_chars(text.data() + at, text.data() + end, lexeme.number);
      if (read.ec != std::errc() || read.ptr != text.data() + end || !std::isfinite(lexeme.number))
        return bad_formula(text, at,
                           "'" + std::string(text.substr(at, std::min<std::size_t>(end - at, 40))) +
                               "' is no number within double precision");
    } else if (c == '.' && end < text.size() && text[end] == '.') {
      ++end;
      lexeme.token = FormulaToken::range;
    } else {
      lexeme.token = single(c);
      if (lexeme.token == FormulaToken::end)
        return bad_formula(text, at,
                           printable(c) ? std::string("'") + c + "' has no meaning in a formula"
                                        : std::string("a byte that is no printable character"));
    }
    lexeme.text = text.substr(at, end - at);
    lexemes.push_back(std::move(lexeme));
    at = end;
  }
  FormulaLexeme last;
  last.at = text.size();
  lexemes.push_back(last);
  return lexemes;
}

}  // namespace driftwise::formats
