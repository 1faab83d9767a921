#pragma once
// Roles as people write them.

#include <string>
#include <vector>

#include "driftwise/v1/access.pb.h"

namespace driftwise::cli {

inline const std::vector<std::string>& role_names() {
  static const std::vector<std::string> names = {"viewer", "controller", "operator", "engineer",
                                                 "admin"};
  return names;
}

inline std::string role_text(v1::Role role) {
  const auto at = static_cast<std::size_t>(role);
  return at >= 1 && at <= role_names().size() ? role_names()[at - 1] : "no role";
}

inline v1::Role role_from_text(const std::string& name) {
  for (std::size_t i = 0; i < role_names().size(); ++i)
    if (role_names()[i] == name) return static_cast<v1::Role>(i + 1);
  return v1::ROLE_UNSPECIFIED;
}

}  // namespace driftwise::cli
