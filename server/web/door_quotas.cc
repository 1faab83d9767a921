#include "server/web/door_quotas.h"

#include <map>
#include <tuple>

namespace driftwise::web {
namespace {

std::string busiest(std::span<const ConnectionState> present) {
  std::map<std::string, std::size_t> counts;
  const std::string* most = nullptr;
  std::size_t count = 0;
  for (const auto& one : present)
    if (++counts[one.peer] > count) {
      count = counts[one.peer];
      most = &one.peer;
    }
  return most ? *most : std::string();
}

}  // namespace

std::optional<std::size_t> makes_room(std::span<const ConnectionState> present,
                                      const std::string& newcomer, const DoorQuotas& quotas) {
  std::size_t of_peer = 0;
  for (const auto& one : present) of_peer += one.peer == newcomer ? 1 : 0;
  if (of_peer < quotas.per_peer && present.size() < quotas.in_all) return std::nullopt;
  const std::string from = of_peer >= quotas.per_peer ? newcomer : busiest(present);
  std::size_t slowest = quotas.in_all;
  for (std::size_t i = 0; i < present.size(); ++i) {
    if (present[i].peer != from || present[i].activity == Activity::stopping) continue;
    const auto rank = [&](std::size_t k) {
      return std::tuple(present[k].activity, present[k].since);
    };
    if (slowest == quotas.in_all || rank(i) < rank(slowest)) slowest = i;
  }
  return slowest;
}

}  // namespace driftwise::web
