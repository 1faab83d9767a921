// Two causes that hide each other: beside the noise that the other one leaves, chance does as well
// as either.

#include <algorithm>
#include <cmath>

#include "server/core/try.h"
#include "server/diagnosis/answer/cancelled.h"
#include "server/diagnosis/growth/extension.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kSupposed = 3;  // causes that are tried as the first of two

// That are furthest beyond their own chance.
std::vector<std::size_t> furthest(const Look& look) {
  std::vector<std::size_t> order;
  for (std::size_t c = 0; c < look.causes.size(); ++c)
    if (look.causes[c].gain > 0 && look.causes[c].beyond > 0) order.push_back(c);
  std::ranges::stable_sort(order, std::ranges::greater{},
                           [&](std::size_t c) { return look.causes[c].beyond; });
  order.resize(std::min(order.size(), kSupposed));
  return order;
}

}  // namespace

Result<bool> Extension::add_two(const Look& look, double alpha) {
  const Search::Chance chance = search_.chance();
  const auto named = named_;
  const auto between_neighbours = between_neighbours_;
  const auto white_sd = white_sd_;
  const auto ruled_out = ruled_out_;
  const auto shapes = shapes_;
  const auto refused = refused_;
  for (const std::size_t cause : furthest(look)) {
    if (index_of(cause)) continue;
    DRIFTWISE_TRY(const bool added, add_beside(cause, look, alpha));
    if (added) return true;
    named_ = named;
    between_neighbours_ = between_neighbours;
    white_sd_ = white_sd;
    ruled_out_ = ruled_out;
    shapes_ = shapes;
    refused_ = refused;
    search_.set_chance(chance);
  }
  return false;
}

// Names and notes are left as they come where nothing was added: add_two() puts them back.
Result<bool> Extension::add_beside(std::size_t cause, const Look& look, double alpha) {
  const std::size_t index = named_.size();
  shapes_ = look.shapes;
  const Candidate first = refined(cause, look.causes[cause], ground({}, shapes_));
  if (!first.nameable) return false;
  DRIFTWISE_TRY(auto supposed, made(first, 1));
  named_.push_back(std::move(supposed));
  update_noise();
  const auto second = search_.look(learned(), allowed());
  if (!second) return cancelled();
  if (!second->first || second->p_adjusted > alpha) return false;
  // Of all pairs one may look so by chance.
  const double pairs = static_cast<double>(causes_.size()) / 2;
  const double both = look.causes[cause].beyond + second->causes[*second->first].beyond;
  if (look.tail.p(both - 2 * std::log(std::max(pairs, 1.0))) > alpha) return false;
  DRIFTWISE_TRY(const bool added, add(*second));
  if (!added || named_.size() != index + 2) return false;
  auto others = allowed();
  others[cause] = 1;
  const auto again = search_.look(learned(index), others);
  if (!again) return cancelled();
  const double p = again->tail.p(again->causes[cause].beyond);
  if (p > alpha) return false;
  const Ground without = ground(index, again->shapes);
  const Candidate beside = refined(cause, again->causes[cause], without);
  if (!beside.nameable) return false;
  if (!gate_score(beside, without, learned(index)).passes()) return false;
  named_[index].p_adjusted = std::max(p, kSmallestP);
  shapes_ = again->shapes;
  return true;
}

}  // namespace driftwise::diagnosis
