#include "tests/hidden_effects/accepting/foreign_orders.h"

#include <algorithm>
#include <tuple>

#include "tests/hidden_effects/foreign/hidden.h"

namespace driftwise::hidden {
namespace {

constexpr int kNulls = 120, kSinglesPerCause = 2, kPairs = 28, kUnlisted = 36;
constexpr double kSingleChi2[] = {75, 150}, kPairChi2 = 200, kUnlistedChi2 = 150;

struct PlacedOrder {
  double place = 0;  // 0 to 1 in its round
  foreign::Order order;
};

std::vector<PlacedOrder> one_round(int round) {
  const auto& causes = foreign::cause_ids();
  const auto& unlisted = foreign::unlisted_ids();
  std::vector<PlacedOrder> orders;
  const auto add = [&](const char* kind, int k, int total, const std::string& cause, double chi2) {
    PlacedOrder one{(k + 0.5) / total, {}};
    one.order.kind = kind;
    one.order.cause = cause;
    one.order.chi2 = chi2;
    one.order.units = "study";
    orders.push_back(one);
  };
  const int count = static_cast<int>(causes.size()), singles = kSinglesPerCause * count;
  for (int k = 0; k < kNulls; ++k) add("null", k, kNulls, "", 0);
  for (const double chi2 : kSingleChi2)
    for (int k = 0; k < singles; ++k)
      add("single", k, singles, causes[static_cast<std::size_t>(k % count)], chi2);
  for (int k = 0; k < kPairs; ++k) {
    const int of_all = round * kPairs + k;
    add("pair", k, kPairs, causes[static_cast<std::size_t>((5 * of_all + 2) % count)], kPairChi2);
  }
  for (int k = 0; k < kUnlisted; ++k)
    add("unlisted", k, kUnlisted, unlisted[static_cast<std::size_t>(k) % unlisted.size()],
        kUnlistedChi2);
  std::ranges::stable_sort(orders, {}, [](const PlacedOrder& one) {
    return std::tuple(one.place, one.order.kind, one.order.chi2);
  });
  return orders;
}

}  // namespace

std::vector<NumberedOrder> paired_orders(std::uint64_t seed_base, int rounds) {
  std::vector<NumberedOrder> orders;
  for (int round = 0; round < rounds; ++round)
    for (auto& placed : one_round(round)) {
      const int number = static_cast<int>(orders.size());
      placed.order.seed = seed_base + static_cast<std::uint64_t>(number);
      orders.push_back({number, std::move(placed.order)});
    }
  return orders;
}

}  // namespace driftwise::hidden
