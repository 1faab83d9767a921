#include "tests/hidden_effects/accepting/foreign_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

#include "tests/hidden_effects/accepting/served_truth.h"

namespace driftwise::hidden {
namespace {

constexpr double kConfidence = 0.95;

using Cases = std::vector<const ForeignCase*>;

Cases chosen(const std::vector<ForeignCase>& cases,
             const std::function<bool(const ForeignCase&)>& wanted) {
  Cases out;
  for (const auto& one : cases)
    if (wanted(one)) out.push_back(&one);
  return out;
}

// "0.91 (0.87 to 0.95)" of n data sets; without an interval for one.
std::string ratio_text(const Cases& cases, bool inside_only = false) {
  std::vector<double> ratios;
  for (const auto* one : cases)
    if (!inside_only || one->rows_inside > 0) ratios.push_back(ratio_of(one->outputs, inside_only));
  if (ratios.empty()) return "-";
  if (ratios.size() == 1) return fmt::format("{:.3f}", ratios.front());
  const auto mean = mean_ratio(ratios, kConfidence);
  return fmt::format("{:.3f} ({:.3f} to {:.3f})", mean.mean, mean.low, mean.high);
}

std::ptrdiff_t harmed_in(const Cases& cases, bool inside_only = false) {
  return std::ranges::count_if(
      cases, [inside_only](const ForeignCase* one) { return has_harm(one->outputs, inside_only); });
}

std::string hidden_text(const ForeignCase& one) {
  std::string text = one.order.kind == "unlisted" ? "in no catalogue: " : "";
  for (const auto& cause : one.hidden) text += (&cause == &one.hidden.front() ? "" : " + ") + cause;
  return one.hidden.empty() ? "nothing" : text;
}

std::vector<std::string> causes_hidden(const ForeignCase& one) {
  if (one.hidden.empty()) return {"nothing hidden"};
  std::vector<std::string> causes;
  for (const auto& cause : one.hidden) causes.push_back(cause.substr(0, cause.find(' ')));
  return causes;
}

void add_outcomes(const std::vector<ForeignCase>& cases, std::string& text) {
  std::map<std::string, int> outcomes;
  std::map<std::string, int> reasons;
  for (const auto& one : cases) {
    ++outcomes[one.outcome];
    if (one.outcome == "refused" || one.outcome == "not_served" || one.outcome == "not_diagnosed")
      ++reasons[one.outcome + ": " + one.reason];
  }
  text += fmt::format("{} data sets:", cases.size());
  for (const auto& [outcome, count] : outcomes) text += fmt::format(" {} {},", count, outcome);
  text.back() = '\n';
  for (const auto& [reason, count] : reasons) text += fmt::format("  {} {}\n", count, reason);
}

void add_harmed(const Cases& accepted, std::string& text) {
  auto harmed = accepted;
  std::erase_if(harmed, [](const ForeignCase* one) { return !has_harm(one->outputs); });
  std::ranges::sort(harmed, std::ranges::greater{},
                    [](const ForeignCase* one) { return ratio_of(one->outputs); });
  text += fmt::format(
      "\nWorse by more than 5 % and 1 nm in an output: {} of {} ({} within the fitted domain)\n",
      harmed.size(), accepted.size(), harmed_in(accepted, true));
  for (const auto* one : harmed) {
    text += fmt::format(
        "  number {} seed {} {} chi2 {:.0f}, {} {} axes, {}, {}: hidden {}; named {}{}\n",
        one->number, one->order.seed, one->order.kind, one->order.chi2, one->robot, one->axes,
        one->plan, one->noise, hidden_text(*one), one->named,
        (one->changed.empty() ? "" : " [" + one->changed + "]") +
            (one->one_of_a_set ? ", one of a set" : ""));
    for (const auto& output : one->outputs)
      text += fmt::format(
          "    {} {:.2f} -> {:.2f} nm rms (mean {:+.2f} -> {:+.2f}; inside the domain {:.2f} -> "
          "{:.2f}){}\n",
          output.output, output.before_nm, output.after_nm, output.mean_before_nm,
          output.mean_after_nm, output.inside_before_nm, output.inside_after_nm,
          is_harmed(output.before_nm, output.after_nm) ? " WORSE" : "");
    text += fmt::format("    {} of {} judged rows inside ({})\n", one->rows_inside,
                        one->rows_judged, one->judged_on);
  }
}

void add_strata(const Cases& accepted, const std::string& title,
                const std::function<std::vector<std::string>(const ForeignCase&)>& names,
                std::string& text) {
  std::map<std::string, Cases> strata;
  for (const auto* one : accepted)
    for (const auto& name : names(*one)) strata[name].push_back(one);
  std::vector<std::pair<std::string, Cases>> sorted(strata.begin(), strata.end());
  const auto mean = [](const Cases& cases) {
    std::vector<double> ratios;
    for (const auto* one : cases) ratios.push_back(ratio_of(one->outputs));
    return ratios.size() < 2 ? ratios.front() : mean_ratio(ratios, kConfidence).mean;
  };
  std::ranges::stable_sort(sorted, std::ranges::greater{},
                           [&](const auto& stratum) { return mean(stratum.second); });
  text += fmt::format("\n| {} | accepted | worse | after / before | inside the domain |\n", title);
  text += "|---|---|---|---|---|\n";
  for (const auto& [name, cases] : sorted)
    text += fmt::format("| {} | {} | {} | {} | {} |\n", name, cases.size(), harmed_in(cases),
                        ratio_text(cases), ratio_text(cases, true));
}

}  // namespace

std::string accepting_report(const std::vector<ForeignCase>& cases) {
  std::string text;
  add_outcomes(cases, text);
  const auto accepted = chosen(cases, [](const ForeignCase& one) { return one.is_accepted(); });
  if (accepted.empty()) return text + "nothing was accepted\n";
  text += fmt::format(
      "accepted {}: rms after / before, geometric mean {}; within the fitted domain {}\n",
      accepted.size(), ratio_text(accepted), ratio_text(accepted, true));
  add_harmed(accepted, text);
  const auto unlisted = chosen(cases, [](const ForeignCase& one) {
    return one.is_accepted() && !one.outputs_as_instrument.empty();
  });
  text += fmt::format(
      "\nIn no catalogue, accepted: {}; worse {} with the effect as the robot's, {} as the "
      "instruments'\n",
      unlisted.size(), harmed_in(unlisted),
      std::ranges::count_if(
          unlisted, [](const ForeignCase* one) { return has_harm(one->outputs_as_instrument); }));
  const auto moving = chosen(cases, [](const ForeignCase& one) {
    return one.is_accepted() && !one.outputs_before_move.empty();
  });
  text += fmt::format(
      "Models that read motor coordinates: {}; worse {} with targets asked for on arrival, {} "
      "before each move\n",
      moving.size(), harmed_in(moving), std::ranges::count_if(moving, [](const ForeignCase* one) {
        return has_harm(one->outputs_before_move);
      }));
  for (const auto* one : moving)
    text += fmt::format(
        "  number {} {}: {}, after / before {:.3f} on arrival, {:.3f} before the move\n",
        one->number, hidden_text(*one), one->named, ratio_of(one->outputs),
        ratio_of(one->outputs_before_move));
  using Names = std::vector<std::string>;
  add_strata(
      accepted, "kind",
      [](const ForeignCase& one) -> Names {
        return {one.order.kind == "single" ? fmt::format("single, chi2 {:.0f}", one.order.chi2)
                                           : one.order.kind};
      },
      text);
  add_strata(
      accepted, "names",
      [](const ForeignCase& one) -> Names {
        return {one.named_right ? "the hidden causes"
                                : "another cause, or one too few or too many"};
      },
      text);
  add_strata(
      accepted, "judged on", [](const ForeignCase& one) -> Names { return {one.judged_on}; }, text);
  add_strata(
      accepted, "robot", [](const ForeignCase& one) -> Names { return {one.robot}; }, text);
  add_strata(
      accepted, "plan", [](const ForeignCase& one) -> Names { return {one.plan}; }, text);
  add_strata(
      accepted, "noise", [](const ForeignCase& one) -> Names { return {one.noise}; }, text);
  add_strata(accepted, "hidden", causes_hidden, text);
  return text;
}

}  // namespace driftwise::hidden
