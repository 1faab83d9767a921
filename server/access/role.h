#pragma once
// Roles: what an identity may do. Pure; any thread.
//
//   viewer      reads, watches, and stops every motion
//   controller  asks for targets
//   operator    moves, runs, confirms, acknowledges, writes notes
//   engineer    changes models, plans, corrections, datasets, holds and cell settings
//   admin       keeps tokens, certificates and backups
//
// Each role includes those above it. So a controller may look and stop, an engineer may move, and
// one comparison decides. Stop needs viewer, the lowest: who may look may stop.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace driftwise::access {

enum class Role : std::uint8_t { viewer = 1, controller, operator_, engineer, admin };

inline constexpr std::array kRoles = {Role::viewer, Role::controller, Role::operator_,
                                      Role::engineer, Role::admin};

constexpr bool includes(Role has, Role needed) { return has >= needed; }

// "viewer", "controller", "operator", "engineer", "admin".
std::string_view to_string(Role role);
std::optional<Role> role_from(std::string_view name);

// URI of a certificate's subject alternative name: "driftwise:role/operator". Other URIs: nothing.
inline constexpr std::string_view kRoleUri = "driftwise:role/";
std::optional<Role> role_from_uri(std::string_view uri);

}  // namespace driftwise::access
