#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "server/formats/indentation/indentation_file.h"
#include "server/formats/indentation/indents_csv.h"
#include "server/formats/indentation/procedure_json.h"

namespace driftwise::formats {
namespace {

std::string shipped(const std::string& name) {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR "/deploy/cells/two-robots/") + name);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(IndentationFile, ReadsTheShippedOne) {
  const auto file = read_indentation_file(shipped("indentation.toml"), "indentation.toml");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->rules.tool, "diamond 3");
  EXPECT_TRUE(file->by_plan);
  ASSERT_EQ(file->rules.indents.size(), 10U);
  EXPECT_TRUE(file->rules.indents[0].closed_loop);
  EXPECT_EQ(file->rules.indents[9].id, "y1000");
  EXPECT_EQ(file->temperatures.size(), 7U);
  EXPECT_DOUBLE_EQ(file->rules.shift_y_mm, 0.1);
}

struct BadFile {
  const char *name, *from, *to, *reason;
};
class BadIndentationFile : public testing::TestWithParam<BadFile> {};
TEST_P(BadIndentationFile, IsRefusedWithItsReason) {
  const auto& bad = GetParam();
  const auto file =
      read_indentation_file(replaced(shipped("indentation.toml"), bad.from, bad.to), "i.toml");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().reason, bad.reason) << file.error().message;
  EXPECT_TRUE(file.error().message.starts_with("i.toml:")) << file.error().message;
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadIndentationFile,
    testing::Values(
        BadFile{"syntax", "name =", "name", "TOML_SYNTAX"},
        BadFile{"unknown_key", "press_mm", "pres_mm", "UNKNOWN_KEY"},
        BadFile{"no_tool", "id = \"diamond 3\"", "", "MISSING_KEY"},
        BadFile{"no_reason", "by = \"plan\"", "by = \"geometry\"", "REASON_REQUIRED"},
        BadFile{"begins_above_its_end", "depart_mm = 1.555", "depart_mm = 1.7", "BAD_VALUE"},
        BadFile{"one_robot_twice", "above = \"mn\"", "above = \"ma\"", "DUPLICATE_ID"},
        BadFile{"a_place_in_um", "zero_mm = [0, 0]", "zero_mm = [500, 0]", "OUT_OF_RANGE"},
        BadFile{"touches_on_a_line", "[[1, 1], [1, -1], [-1, -1]]", "[[1, 1], [0, 0], [-1, -1]]",
                "POINTS_ON_A_LINE"},
        BadFile{"an_indent_twice", "x_um = [250, 500", "x_um = [250, 250", "DUPLICATE_ID"},
        BadFile{"two_touches", "[[1, 1], [1, -1], [-1, -1]]", "[[1, 1], [1, -1]]", "BAD_VALUE"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(IndentsCsv, ReadsThePublishedTableAndWritesItBack) {
  const auto indents = read_indents_csv(shipped("table_8_1.csv"), "table_8_1.csv");
  ASSERT_TRUE(indents) << indents.error().message;
  ASSERT_EQ(indents->size(), 10U);
  EXPECT_EQ((*indents)[4].id, "F");
  EXPECT_DOUBLE_EQ((*indents)[4].measured_um, 1025.02);
  EXPECT_EQ((*indents)[4].pictures_joined, 3);
  const auto again = read_indents_csv(write_indents_csv(*indents), "again.csv");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(write_indents_csv(*again), write_indents_csv(*indents));
}

TEST(IndentsCsv, NamesThePlaceOfWhatItRefuses) {
  const auto reason = [](const char* from, const char* to) {
    const auto read = read_indents_csv(replaced(shipped("table_8_1.csv"), from, to), "t.csv");
    EXPECT_FALSE(read);
    return read ? "" : read.error().reason + " " + read.error().message.substr(0, 8);
  };
  EXPECT_EQ(reason("C,x", "C,z"), "BAD_VALUE t.csv:4:");
  EXPECT_EQ(reason("255.90", "wide"), "BAD_NUMBER t.csv:4:");
  EXPECT_EQ(reason(",pixel_nm", ",pixels"), "NO_COLUMN t.csv:2:");
  EXPECT_EQ(reason("A,x,100", "A,x"), "RAGGED_ROW t.csv:3:");
}

TEST(MicroscopeCsv, ReadsContactsByTheirNumber) {
  const std::string head = "id,x_um,y_um,pixel_nm,marking_px,pictures_joined\n";
  const auto rows = read_microscope_csv(head + "7,0,0,140,2.5,0\n8,102.9,0.1,140,2.5,0\n", "m.csv");
  ASSERT_TRUE(rows) << rows.error().message;
  EXPECT_EQ((*rows)[1].id, 8);
  EXPECT_DOUBLE_EQ((*rows)[1].x_um, 102.9);
  EXPECT_EQ(read_microscope_csv(head + "0,0,0,140,2.5,0\n", "m.csv").error().reason, "BAD_VALUE");
  EXPECT_EQ(read_microscope_csv(head + "7,,0,140,2.5,0\n", "m.csv").error().reason, "BAD_VALUE");
  EXPECT_EQ(read_microscope_csv(head, "m.csv").error().reason, "NO_ROWS");
}

TEST(ProcedureJson, KeepsEveryField) {
  indentation::ProcedureRecord record;
  record.key = "a key";
  record.stage = indentation::Stage::indents;
  record.tool = "diamond 3";
  record.revision = 31;
  record.contacts = 9;
  record.in_contact = true;
  record.aside_um = 20;
  record.anew = 1;
  record.rx_arcsec = -540.25;
  record.heights_by = {.work_mm = 0.9, .source = "plan 1"};
  record.log = {"align: a \"sentence\""};
  record.zero_here.degc = {{"t04_degC", 21.5}};
  record.indents.push_back({.planned = {.id = "x100", .at_um = 100, .closed_loop = true},
                            .touch = {.height_mm = 1.6, .contact = 8},
                            .rx_arcsec = -1.6});
  record.contact_list.push_back({.touch = {.x_mm = 0.5, .contact = 9},
                                 .stage = indentation::Stage::zero,
                                 .round = 1,
                                 .indent = "x100",
                                 .by = "plan 1",
                                 .at = "2011-05-01T10:00:00Z",
                                 .trouble = "lost"});
  record.rounds.push_back({.round = 1, .accepted = true, .spread_nm = 250, .by = "plan 1"});
  const std::string text = procedure_json(record);
  const auto read = read_procedure_json(text, "state.json");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(procedure_json(*read), text);
  EXPECT_EQ(read->revision, 31);
  EXPECT_EQ(read->anew, 1);
  EXPECT_EQ(read->heights_by->source, "plan 1");
  EXPECT_EQ(read->heights_by->work_mm, 0.9);
}

TEST(ProcedureJson, IsRefusedWhenItIsDeepInsteadOfOverflowingTheStack) {
  const std::string lists = std::string(100000, '[') + std::string(100000, ']');
  for (const char* key : {"\"contact_list\": []", "\"rounds\": []", "\"touches\": []"}) {
    const std::string deep = std::string(key).substr(0, std::string(key).size() - 2) + lists;
    const auto read = read_procedure_json(replaced(procedure_json({}), key, deep), "s.json");
    ASSERT_FALSE(read) << key;
    EXPECT_EQ(read.error().reason, "JSON_SYNTAX");
    EXPECT_NE(read.error().message.find("more than 100 lists"), std::string::npos)
        << read.error().message.substr(0, 200);
  }
}

TEST(ProcedureJson, IsRefusedWithANumberBeyondDoubles) {
  const auto read =
      read_procedure_json(replaced(procedure_json({}), "\"align\"", "1e999"), "s.json");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().reason, "JSON_SYNTAX");
}

TEST(ProcedureJson, OfARecordWithoutTheLaterListsIsRead) {
  std::string text = replaced(procedure_json({}), "\"contact_list\"", "\"of_later\"");
  text = replaced(std::move(text), "\"rounds\"", "\"of_later_too\"");
  text = replaced(std::move(text), "\"revision\"", "\"of_later_yet\"");
  EXPECT_TRUE(read_procedure_json(text, "s.json"));
}

TEST(ProcedureJson, IsRefusedWhenItIsDamaged) {
  const std::string text = procedure_json({});
  EXPECT_EQ(read_procedure_json(text.substr(0, 40), "s.json").error().reason, "JSON_SYNTAX");
  EXPECT_EQ(read_procedure_json(replaced(text, "\"align\"", "\"aligm\""), "s.json").error().reason,
            "BAD_VALUE");
  EXPECT_EQ(read_procedure_json("{}", "s.json").error().reason, "BAD_VALUE");
}

}  // namespace
}  // namespace driftwise::formats
