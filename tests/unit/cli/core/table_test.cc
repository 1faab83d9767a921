// Tables for people.

#include "clients/cli/core/table.h"

#include <gtest/gtest.h>

#include <sstream>

namespace driftwise::cli {
namespace {

std::string printed(const Table& table) {
  std::ostringstream out;
  table.print(out, Paint(false));
  return out.str();
}

TEST(Table, AlignsItsColumns) {
  Table table({{"name"}, {"nm", Align::right}, {"by"}});
  table.add({"short", "3.5", "ada"});
  table.add({"somewhat longer", "12.25", "bob"});
  EXPECT_EQ(printed(table),
            "name                nm  by\n"
            "short              3.5  ada\n"
            "somewhat longer  12.25  bob\n");
}

// A note of 300 characters in the middle of one row makes no other row 300 characters long.
TEST(Table, ACellOfManyCharactersStandsOutInItsOwnRow) {
  Table table({{"name"}, {"value"}, {"by"}});
  table.add({"a", "1", "ada"});
  table.add({"b", std::string(300, 'x'), "bob"});
  EXPECT_EQ(printed(table),
            "name  value  by\na     1      ada\nb     " + std::string(300, 'x') + "  bob\n");
}

}  // namespace
}  // namespace driftwise::cli
