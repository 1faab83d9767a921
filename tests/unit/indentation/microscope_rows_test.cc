// A microscope's table onto a record of six indents along two lines, one contact of which was
// interrupted.
#include "server/indentation/microscope_rows.h"

#include <gtest/gtest.h>

#include <vector>

namespace driftwise::indentation {
namespace {

ProcedureRecord made_indents() {
  ProcedureRecord record;
  record.zero.contact = 7;
  int contact = 8;
  for (const Line line : {Line::x, Line::y})
    for (const double at_um : {100.0, 250.0, 500.0}) {
      if (contact == 9) ++contact;  // interrupted
      const std::string id = (line == Line::x ? "x" : "y") + std::to_string(int(at_um));
      record.indents.push_back(
          {.planned = {.id = id, .line = line, .at_um = at_um}, .touch = {.contact = contact++}});
    }
  return record;
}

// Errors of 2.5 % and a crosswise 3 um, with the zero somewhere in the picture.
std::vector<MicroscopeIndent> seen_indents(const ProcedureRecord& record) {
  std::vector<MicroscopeIndent> rows = {{.id = record.zero.contact, .x_um = 1200, .y_um = -340}};
  for (const auto& one : record.indents) {
    const bool is_x = one.planned.line == Line::x;
    const double along_um = 1.025 * one.planned.at_um;
    rows.push_back({.id = one.touch.contact,
                    .x_um = 1200 + (is_x ? along_um : 3),
                    .y_um = -340 + (is_x ? 3 : along_um),
                    .pixel_nm = 140,
                    .marking_px = 2});
  }
  return rows;
}

TEST(MicroscopeRows, GiveDistancesFromTheZeroAlongEachLine) {
  const auto record = made_indents();
  const auto indents = indents_seen(record, seen_indents(record));
  ASSERT_TRUE(indents) << indents.error().message;
  ASSERT_EQ(indents->size(), 6U);
  EXPECT_NEAR((*indents)[2].measured_um, 512.5, 1e-9);
  EXPECT_NEAR((*indents)[5].measured_um, 512.5, 1e-9);
}

// An interrupted contact near the zero: the indent was made again 20 um aside, nearer to where its
// neighbour was planned.
TEST(MicroscopeRows, AreComparedWithWhereTheIndentsWereMade) {
  ProcedureRecord record;
  record.zero = {.x_mm = 1, .y_mm = 2, .contact = 1};
  record.indents = {{.planned = {.id = "x10", .line = Line::x, .at_um = 10},
                     .touch = {.x_mm = 1.010, .y_mm = 2.020, .contact = 3}},
                    {.planned = {.id = "y15", .line = Line::y, .at_um = 15},
                     .touch = {.x_mm = 1, .y_mm = 2.015, .contact = 4}}};
  const std::vector<MicroscopeIndent> rows = {{.id = 1, .x_um = 0, .y_um = 0},
                                              {.id = 3, .x_um = 10, .y_um = 20},
                                              {.id = 4, .x_um = 0, .y_um = 15}};
  const auto indents = indents_seen(record, rows);
  ASSERT_TRUE(indents) << indents.error().message;
  EXPECT_NEAR((*indents)[0].measured_um, 10, 1e-9);
}

// The contact between them left no mark: in the microscope the indents after it are counted on.
TEST(MicroscopeRows, AreRefusedWhereTheirNumbersAreShifted) {
  const auto record = made_indents();
  auto rows = seen_indents(record);
  for (auto& row : rows)
    if (row.id > 9) --row.id;
  rows.push_back({.id = 13, .x_um = 0, .y_um = 0, .pixel_nm = 140, .marking_px = 2});
  const auto indents = indents_seen(record, rows);
  ASSERT_FALSE(indents);
  EXPECT_EQ(indents.error().reason, "IDS_SHIFTED");
  EXPECT_NE(indents.error().message.find("indent x250 by its number"), std::string::npos)
      << indents.error().message;
}

// The same picture by a microscope whose axes point elsewhere: the numbers are right.
TEST(MicroscopeRows, AreToldThatThePictureIsMirroredOrTurned) {
  struct Frame {
    int xx, xy, yx, yy;  // of the picture by the robot's x and y
    const char* correction;
  };
  const auto record = made_indents();
  for (const Frame& one : {Frame{1, 0, 0, -1, "mirrored, y_um points the other way"},
                           Frame{-1, 0, 0, 1, "mirrored, x_um points the other way"},
                           Frame{-1, 0, 0, -1, "turned by 180 degrees"},
                           Frame{0, 1, -1, 0, "write -y_um as x_um and x_um as y_um"},
                           Frame{0, -1, 1, 0, "write y_um as x_um and -x_um as y_um"},
                           Frame{0, 1, 1, 0, "exchange the two columns"},
                           Frame{0, -1, -1, 0, "write -y_um as x_um and -x_um as y_um"}}) {
    auto rows = seen_indents(record);
    for (auto& row : rows) {
      const double x_um = row.x_um, y_um = row.y_um;
      row.x_um = one.xx * x_um + one.xy * y_um;
      row.y_um = one.yx * x_um + one.yy * y_um;
    }
    const auto indents = indents_seen(record, rows);
    ASSERT_FALSE(indents) << one.correction;
    EXPECT_EQ(indents.error().reason, "WRONG_COORDINATES") << one.correction;
    EXPECT_NE(indents.error().message.find(one.correction), std::string::npos)
        << indents.error().message;
    EXPECT_EQ(indents.error().message.find("correct the ids"), std::string::npos);
  }
}

TEST(MicroscopeRows, NameTheIndentThatWasNotMeasured) {
  const auto record = made_indents();
  auto rows = seen_indents(record);
  rows.erase(rows.begin() + 3);
  EXPECT_EQ(indents_seen(record, rows).error().reason, "NO_SUCH_ROW");
}

}  // namespace
}  // namespace driftwise::indentation
