#include "server/effects/term_order.h"
#include "server/formats/formula/formula_tree.h"

namespace driftwise::formats {
namespace {

using Kind = FormulaNode::Kind;

void print(const FormulaNode& node, std::string& text);

void print_joined(const FormulaNode& node, const char* by, std::string& text) {
  for (std::size_t i = 0; i < node.parts.size(); ++i) {
    if (i > 0) text += by;
    print(node.parts[i], text);
  }
}

void print_sum(const FormulaNode& node, std::string& text) {
  for (std::size_t i = 0; i < node.parts.size(); ++i) {
    if (i > 0)
      text += node.signs[i] == '-' ? " - " : " + ";
    else if (node.signs[i] == '-')
      text += "- ";
    print(node.parts[i], text);
  }
}

void print_effect(const FormulaNode& node, std::string& text) {
  text += node.name + "(";
  print_joined(node, ", ", text);
  for (std::size_t i = 0; i < node.quantities.size(); ++i) {
    if (i > 0 || !node.parts.empty()) text += ", ";
    text += effects::number_text(node.quantities[i].value);
    if (!node.quantities[i].unit.empty()) text += " " + node.quantities[i].unit;
  }
  text += ")";
}

void print(const FormulaNode& node, std::string& text) {
  switch (node.kind) {
    case Kind::name:
      text += node.name;
      return;
    case Kind::range:
      text += node.name + ".." + node.name_to;
      return;
    case Kind::one:
      text += "1";
      return;
    case Kind::power:
      print(node.parts.front(), text);
      text += "^" + std::to_string(node.number);
      return;
    case Kind::poly:
      text += "poly(";
      print_joined(node, ", ", text);
      text += ", " + std::to_string(node.number) + ")";
      return;
    case Kind::effect:
      print_effect(node, text);
      return;
    case Kind::cross:
      print_joined(node, ":", text);
      return;
    case Kind::star:
      print_joined(node, "*", text);
      return;
    case Kind::sum:
      if (node.parenthesised) text += "(";
      print_sum(node, text);
      if (node.parenthesised) text += ")";
      return;
  }
}

}  // namespace

std::string print_formula(const ParsedFormula& formula) {
  std::string text;
  for (const auto& output : formula.outputs) text += (text.empty() ? "" : " + ") + output.name;
  text += " ~ ";
  print(formula.sum, text);
  return text;
}

}  // namespace driftwise::formats
