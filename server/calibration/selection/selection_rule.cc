#include "server/calibration/selection/selection_rule.h"

#include <vector>

#include "server/calibration/selection/hierarchy.h"
#include "server/core/reasons.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

constexpr int kMostStarts = 10000;

tl::unexpected<Error> bad_option(std::string why) {
  return fail(ErrorCode::invalid_argument, reasons::kBadOptions, std::move(why));
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// What is always in brings its parents in for good, and theirs.
void keep_parents(const std::vector<std::vector<int>>& parents, std::vector<char>& always) {
  std::vector<int> open;
  for (std::size_t j = 0; j < always.size(); ++j)
    if (always[j] != 0) open.push_back(static_cast<int>(j));
  while (!open.empty()) {
    const int child = open.back();
    open.pop_back();
    for (const int parent : parents[static_cast<std::size_t>(child)]) {
      auto& kept = always[static_cast<std::size_t>(parent)];
      if (kept == 0) open.push_back(parent);
      kept = 1;
    }
  }
}

}  // namespace

Result<void> check_options(const FitOptions& options) {
  const auto probability = [](double p) { return p > 0 && p < 1; };
  if (!probability(options.p_enter) || !probability(options.p_remove))
    return bad_option("p_enter is " + effects::number_text(options.p_enter) + " and p_remove " +
                      effects::number_text(options.p_remove) + ": both must lie between 0 and 1");
  if (options.p_remove < options.p_enter)
    return bad_option("p_remove " + effects::number_text(options.p_remove) + " is below p_enter " +
                      effects::number_text(options.p_enter) +
                      ": a term would enter and leave for ever; raise p_remove");
  if (!options.candidates.constant && options.select == Select::stepwise)
    return bad_option(
        "the constant is always in a stepwise fit: use \"- 1\" only with --select all");
  if (options.starts < 1 || options.starts > kMostStarts)
    return bad_option(std::to_string(options.starts) + " starts are asked for: from 1 to " +
                      std::to_string(kMostStarts) + " can be tried");
  if (options.starts > 1 && options.select == Select::all)
    return bad_option("select all puts every term in: several starts are for a stepwise selection");
  return {};
}

Result<SelectionRule> selection_rule(const FitOptions& options, Design& design) {
  SelectionRule rule;
  rule.stepwise = options.select == Select::stepwise;
  rule.p_enter = options.p_enter;
  rule.p_remove = options.p_remove;
  rule.criterion = options.criterion;
  rule.starts = options.starts;
  rule.seed = options.seed;
  if (!options.hierarchy) return rule;
  Hierarchy hierarchy = hierarchy_of(design.terms);
  keep_parents(hierarchy.parents, design.always);
  for (std::size_t j = 0; j < design.terms.size(); ++j) {
    const auto& missing = hierarchy.missing[j];
    if (!missing.empty() && (!rule.stepwise || design.always[j] != 0))
      return bad_option("hierarchy: " + effects::notation(design.terms[j]) +
                        " must be in, and its parent " + listed(missing) +
                        " is not offered: offer it too, or fit without hierarchy");
    rule.barred.push_back(missing.empty() ? 0 : 1);
  }
  rule.parents = std::move(hierarchy.parents);
  return rule;
}

std::vector<std::string> barred_sentences(const Design& design, const SelectionRule& rule) {
  std::vector<std::string> sentences;
  if (rule.barred.empty()) return sentences;
  const Hierarchy hierarchy = hierarchy_of(design.terms);
  for (std::size_t j = 0; j < design.terms.size(); ++j)
    if (rule.barred[j] != 0)
      sentences.push_back("hierarchy: " + effects::notation(design.terms[j]) + " needs " +
                          listed(hierarchy.missing[j]) + ", which is not offered: it cannot enter");
  return sentences;
}

}  // namespace driftwise::calibration
