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

TEST(Table, PaintsACellAroundItsTextAndCountsTheTextAlone) {
  Table table({{"verdict"}, {"value", Align::right}, {"by"}});
  table.add({{"good", Colour::good}, {"1", Colour::warn}, ""});
  table.add({"not declared", {"", Colour::bad}, "ada"});
  std::ostringstream out;
  table.print(out, Paint(true));
  EXPECT_EQ(out.str(),
            "\x1b[1mverdict       value  by\x1b[0m\n"
            "\x1b[32mgood\x1b[0m              \x1b[33m1\x1b[0m\n"
            "not declared         ada\n");
  EXPECT_EQ(printed(table),
            "verdict       value  by\ngood              1\nnot declared         ada\n");
}

TEST(Table, ShowsWhatATerminalWouldObeyAsText) {
  Table table({{"note"}});
  table.add({{"\x1b[2J", Colour::bad}});
  std::ostringstream out;
  table.print(out, Paint(true));
  EXPECT_EQ(out.str().find("\x1b[2J"), std::string::npos);
}

}  // namespace
}  // namespace driftwise::cli
