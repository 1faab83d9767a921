#include "server/access/role.h"

namespace driftwise::access {

std::string_view to_string(Role role) {
  switch (role) {
    case Role::viewer:
      return "viewer";
    case Role::controller:
      return "controller";
    case Role::operator_:
      return "operator";
    case Role::engineer:
      return "engineer";
    case Role::admin:
      return "admin";
  }
  return "none";
}

std::optional<Role> role_from(std::string_view name) {
  for (const Role role : kRoles)
    if (to_string(role) == name) return role;
  return std::nullopt;
}

std::optional<Role> role_from_uri(std::string_view uri) {
  if (!uri.starts_with(kRoleUri)) return std::nullopt;
  return role_from(uri.substr(kRoleUri.size()));
}

}  // namespace driftwise::access
