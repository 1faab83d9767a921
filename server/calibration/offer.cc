#include "server/calibration/offer.h"

#include <algorithm>
#include <unordered_set>

#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using effects::Term;

std::unordered_set<std::string> notations(const std::vector<Term>& terms) {
  std::unordered_set<std::string> texts;
  for (const auto& term : terms) texts.insert(effects::notation(term));
  return texts;
}

// The terms of one list that the other has not.
std::vector<Term> beyond(const std::vector<Term>& terms,
                         const std::unordered_set<std::string>& known) {
  std::vector<Term> rest;
  for (const auto& term : terms)
    if (!known.contains(effects::notation(term))) rest.push_back(term);
  return rest;
}

double best_p(const OutputModel& model, const std::unordered_set<std::string>& offered) {
  double best = 1;
  for (const auto& report : model.report)
    if (offered.contains(effects::notation(report.term))) best = std::min(best, report.p);
  return best;
}

}  // namespace

Result<std::vector<OfferResult>> weigh_offers(const Dataset& dataset, const FitOptions& base,
                                              const Model& base_model,
                                              const std::vector<Offer>& offers) {
  std::vector<OfferResult> results;
  for (const auto& offer : offers) {
    const auto fresh = beyond(offer.terms, notations(base.candidates.terms));
    const auto fresh_texts = notations(fresh);
    FitOptions wider = base;
    wider.candidates.terms.insert(wider.candidates.terms.end(), fresh.begin(), fresh.end());
    DRIFTWISE_TRY(auto model, fit(dataset, wider));
    FitOptions pressed = wider;
    pressed.forced.insert(pressed.forced.end(), fresh.begin(), fresh.end());
    pressed.blocks = 0;
    const auto forced = fit(dataset, pressed);  // may be impossible: terms without independent data
    for (std::size_t o = 0; o < model.outputs.size(); ++o) {
      const auto& before = base_model.outputs[o];
      const auto& after = model.outputs[o];
      OfferResult result;
      result.name = offer.name;
      result.output = after.channel.symbol;
      for (const auto& term : after.terms)
        if (fresh_texts.contains(effects::notation(term))) result.taken.push_back(term);
      result.left = beyond(before.terms, notations(after.terms));
      result.best_p = best_p(after, fresh_texts);
      result.u90_validation_before = before.accuracy.u90_validation;
      result.u90_validation_after = after.accuracy.u90_validation;
      result.u90_blocks_before = before.accuracy.u90_blocks;
      result.u90_blocks_after = after.accuracy.u90_blocks;
      result.a90_validation_before = before.accuracy.a90_validation;
      result.a90_validation_after = after.accuracy.a90_validation;
      result.a90_blocks_before = before.accuracy.a90_blocks;
      result.a90_blocks_after = after.accuracy.a90_blocks;
      if (forced) {
        result.u90_validation_forced = forced->outputs[o].accuracy.u90_validation;
        result.a90_validation_forced = forced->outputs[o].accuracy.a90_validation;
      }
      results.push_back(std::move(result));
    }
  }
  return results;
}

std::vector<Offer> published_offers(const Dataset& dataset, const Candidates& candidates,
                                    double tau_s) {
  std::vector<std::string> pose, temperatures, forces;
  for (const auto& term : candidates.terms) {
    for (const auto& symbol : effects::symbols_of(term)) {
      const DatasetColumn* column = dataset.find(symbol);
      auto* list = is_pose_symbol(symbol)                                           ? &pose
                   : column != nullptr && is_structure_temperature(column->channel) ? &temperatures
                   : column != nullptr && column->channel.unit == "N"               ? &forces
                                                                                    : nullptr;
      if (list != nullptr && std::ranges::find(*list, symbol) == list->end())
        list->push_back(symbol);
    }
  }
  Offer coupling{"cross terms position x force", {}},
      cross{"cross terms position x temperature", {}}, rates{"derivatives of the temperatures", {}},
      orders{"3rd and 4th order of the position", {}};
  for (const auto& position : pose) {
    for (const auto& force : forces)
      coupling.terms.push_back(
          effects::product({{effects::Power{position, 1}}}, {{effects::Power{force, 1}}}));
    for (const auto& temperature : temperatures)
      cross.terms.push_back(
          effects::product({{effects::Power{position, 1}}}, {{effects::Power{temperature, 1}}}));
    for (const int order : {3, 4}) orders.terms.push_back({{effects::Power{position, order}}});
  }
  for (const auto* effect : {"rate", "rate2"})
    for (const auto& temperature : temperatures)
      rates.terms.push_back({{effects::Call{effect, {temperature}, {{tau_s, "s"}}}}});
  std::vector<Offer> offers;
  for (auto* offer : {&coupling, &cross, &rates, &orders})
    if (!offer->terms.empty() && (offer != &rates || !dataset.time_s.empty()))
      offers.push_back(std::move(*offer));
  return offers;
}

}  // namespace driftwise::calibration
