#include "server/formats/import/mapping_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace driftwise::formats {
namespace {

constexpr const char* kColumn = "[[column]]\nsource = \"x\"\nchannel = \"x_mm\"\n";

struct MappingMistake {
  const char* name;
  std::string text;
  const char* reason;
  const char* says;
};
class BadMapping : public testing::TestWithParam<MappingMistake> {};
TEST_P(BadMapping, IsRefusedWithFileLineKeyFoundAndExpected) {
  const auto mapping = read_import_mapping(GetParam().text, "map.toml");
  ASSERT_FALSE(mapping);
  EXPECT_EQ(mapping.error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(mapping.error().reason, GetParam().reason) << mapping.error().message;
  EXPECT_THAT(mapping.error().message, testing::StartsWith("map.toml:"));
  EXPECT_THAT(mapping.error().message, testing::HasSubstr(GetParam().says));
}
const std::string kGood = kColumn;
INSTANTIATE_TEST_SUITE_P(
    Table, BadMapping,
    testing::Values(
        MappingMistake{"Empty", "", "NO_COLUMNS", "expected one per channel"},
        MappingMistake{"Syntax", "[file\n", "TOML_SYNTAX", "map.toml:1: column"},
        MappingMistake{"NoChannel", "[[column]]\nsource = 1\n", "MISSING_KEY",
                       "column 1: channel: found nothing"},
        MappingMistake{"NoUnit", "[[column]]\nsource = 1\nchannel = \"x\"\n", "BAD_CHANNEL",
                       "map.toml:3: column 1: channel: 'x' is no channel"},
        MappingMistake{"Set", "[[column]]\nsource = 1\nchannel = \"set\"\n", "BAD_CHANNEL",
                       "[sets] table"},
        MappingMistake{"OtherKind", kGood + "unit = \"K\"\n", "UNIT_KIND", "found K"},
        MappingMistake{"UnknownUnit", kGood + "unit = \"furlong\"\n", "UNKNOWN_UNIT", "'furlong'"},
        MappingMistake{"ZeroScale", kGood + "scale = 0\n", "OUT_OF_RANGE", "found 0"},
        MappingMistake{"Typo", kGood + "[file]\nseperator = \";\"\n", "UNKNOWN_KEY",
                       "did you mean separator?"},
        MappingMistake{"LongSeparator", kGood + "[file]\nseparator = \"::\"\n", "OUT_OF_RANGE",
                       "expected one character, tab or blanks"},
        MappingMistake{"SameMarks", kGood + "[file]\ndecimal = \",\"\n", "BAD_RULE",
                       "found the decimal mark"},
        MappingMistake{"DigitMark", kGood + "[file]\ndecimal = \"0\"\n", "OUT_OF_RANGE", "'0'"},
        MappingMistake{"Encoding", kGood + "[file]\nencoding = \"ebcdic\"\n", "OUT_OF_RANGE",
                       "expected one of utf-8"},
        MappingMistake{"TimeFormat", kGood + "[time]\ncolumn = \"t\"\nformat = \"%H\"\n",
                       "BAD_TIME_FORMAT", "time: format"},
        MappingMistake{"NoTimeColumn", kGood + "[time]\nformat = \"iso8601\"\n", "MISSING_KEY",
                       "expected column"},
        MappingMistake{"Twins", kGood + kGood, "DUPLICATE_CHANNEL", "'x_mm' is given twice"},
        MappingMistake{"TwinsInTwoUnits", kGood + "[[column]]\nsource = 2\nchannel = \"x_um\"\n",
                       "DUPLICATE_CHANNEL", "'x_um' is given twice, also as 'x_mm'"},
        MappingMistake{"Format", kGood + "[metadata]\ndriftwise-dataset = \"7\"\n", "BAD_RULE",
                       "metadata: found the key driftwise-dataset"},
        MappingMistake{"NamesOfSets", kGood + "[metadata]\nset_names = \"inside\"\n", "BAD_RULE",
                       "metadata: found the key set_names"},
        MappingMistake{"IdleDrop", kGood + "[[drop]]\ncolumn = 1\nwhy = \"x\"\n", "BAD_RULE",
                       "drop 1: column: expected missing = true, below, above or equals"},
        MappingMistake{"GroupOfNothing", kGood + "[group]\nchannels = [\"y_mm\"]\n", "BAD_CHANNEL",
                       "group: found 'y_mm'"},
        MappingMistake{"GroupInto", kGood + "[group]\nchannels = \"x_mm\"\ninto = \"goal_mm\"\n",
                       "BAD_CHANNEL", "such as goal_1"},
        MappingMistake{"TwoSets", kGood + "[sets]\nvalidation_every = 5\nvalidation_share = 0.1\n",
                       "BAD_RULE", "expected one of"},
        MappingMistake{"SetWords", kGood + "[sets]\ncolumn = \"s\"\n", "BAD_RULE", "together"},
        MappingMistake{"PoseOfTwo", kGood + "[[pose]]\nposition = [\"x_mm\", \"y_mm\"]\n",
                       "BAD_CHANNEL", "expected three channels such as x_mm"},
        MappingMistake{"PoseOfOthers",
                       kGood + "[[pose]]\nposition = [\"x_mm\", \"y_mm\", \"z_mm\"]\n",
                       "BAD_CHANNEL", "pose: found 'y_mm'"},
        MappingMistake{"Convention",
                       kGood + "[[pose]]\nposition = \"x_mm\"\nconvention = \"euler\"\n",
                       "BAD_CHANNEL", "expected three channels"},
        MappingMistake{"Matrix",
                       kGood + "[[pose]]\nposition = [\"x_mm\", \"x_mm\", \"x_mm\"]\n"
                               "[pose.frame]\nmatrix = [[1,0,0,0],[0,2,0,0],[0,0,1,0]]\n",
                       "NOT_A_ROTATION", "pose 1, frame: matrix"},
        MappingMistake{"ToolWithoutAngles",
                       kGood + "[[pose]]\nposition = [\"x_mm\", \"x_mm\", \"x_mm\"]\n"
                               "[pose.tool]\ntranslation_mm = [0, 0, 1]\n",
                       "BAD_RULE", "expected the pose's three angles"},
        MappingMistake{"Constant", kGood + "[constants]\nforce = 1\n", "BAD_CHANNEL", "'force'"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(ImportMapping, KnowsItsTextByAHash) {
  EXPECT_NE(read_import_mapping(kGood, "a")->hash, read_import_mapping(kGood + "\n", "a")->hash);
}

TEST(ImportMapping, TakesAMatrixThatWasWrittenWithFewDigits) {
  const auto mapping = read_import_mapping(
      kGood +
          "[[column]]\nsource = 2\nchannel = \"rx_deg\"\n"
          "[[pose]]\nposition = [\"x_mm\", \"x_mm\", \"x_mm\"]\n"
          "rotation = [\"rx_deg\", \"rx_deg\", \"rx_deg\"]\n[pose.tool]\n"
          "matrix = [[-0.00079633, 0.99999968, 0, 0], [-0.99999937, -0.00079633, -0.00079633, "
          "0.0868], [-0.00079633, -0.00000063, 0.99999968, -109], [0, 0, 0, 1]]\ninverse = "
          "true\n",
      "map.toml");
  ASSERT_TRUE(mapping) << mapping.error().message;
  // Given the other way round, the translation is the flange seen from the target: 109 mm along z.
  EXPECT_NEAR(mapping->poses[0].tool.translation_mm.z(), 109, 1e-3);
  EXPECT_LT(mapping->poses[0].tool.translation_mm.head<2>().norm(), 1e-3);
}

}  // namespace
}  // namespace driftwise::formats
