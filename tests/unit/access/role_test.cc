#include "server/access/role.h"

#include <gtest/gtest.h>

#include <string>

namespace driftwise::access {
namespace {

TEST(Role, IncludesThoseBelowIt) {
  for (std::size_t has = 0; has < kRoles.size(); ++has)
    for (std::size_t needed = 0; needed < kRoles.size(); ++needed)
      EXPECT_EQ(includes(kRoles[has], kRoles[needed]), has >= needed);
}

TEST(Role, HasANameAndAUriThatReadBack) {
  for (const Role role : kRoles) {
    EXPECT_EQ(role_from(to_string(role)), role);
    EXPECT_EQ(role_from_uri("driftwise:role/" + std::string(to_string(role))), role);
  }
  EXPECT_EQ(role_from_uri("driftwise:role/operator"), Role::operator_);
}

TEST(Role, IsNoOtherText) {
  for (const char* text : {"", "Admin", "admin ", "root", "operator/admin", "driftwise:role/admin"})
    EXPECT_EQ(role_from(text), std::nullopt) << text;
  for (const char* uri :
       {"", "admin", "driftwise:role/", "driftwise:role/Admin", "DRIFTWISE:role/admin",
        "https://x/driftwise:role/admin", "driftwise:role/admin/viewer", "driftwise:role//admin"})
    EXPECT_EQ(role_from_uri(uri), std::nullopt) << uri;
}

TEST(Role, IsNotReadFromAUriWithAZeroByteInIt) {
  EXPECT_EQ(role_from_uri(std::string_view("driftwise:role/admin\0", 21)), std::nullopt);
}

}  // namespace
}  // namespace driftwise::access
