// Lines of metadata that a computation reads: a slip is refused, not passed over.
#include "server/formats/csv/metadata_check.h"

#include <gmock/gmock.h>

#include "server/core/data/dataset_parts.h"
#include "server/formats/csv/dataset_csv.h"

namespace driftwise::formats {
namespace {

using testing::HasSubstr;

Result<Dataset> read_with(const std::string& line) {
  return read_dataset_csv("# driftwise-dataset: 1\n" + line + "\nx_mm,t01_degC,t02_degC\n1,20,21\n",
                          "lab.csv");
}

struct Slip {
  const char* name;
  const char* line;
  const char* says;
};
class MetadataSlip : public testing::TestWithParam<Slip> {};

TEST_P(MetadataSlip, IsRefusedWithItsLineAndWord) {
  const auto data = read_with(GetParam().line);
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().reason, "BAD_METADATA");
  EXPECT_THAT(data.error().message, HasSubstr("lab.csv:2: '# "));
  EXPECT_THAT(data.error().message, HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    Table, MetadataSlip,
    testing::Values(
        Slip{"Comma", "# parts: t01=robot, t02=robot", "found 't01=robot,', expected t01=robot"},
        Slip{"Blanks", "# parts: t01 = robot", "found 't01', expected words such as"},
        Slip{"Case", "# parts: t01=Robot t02=robot", "did you mean robot?"},
        Slip{"Part", "# parts: t01=frame t02=robot", "t01=instrument or t01=air"},
        Slip{"Channel", "# parts: t01=robot T02=robot", "no channel 'T02', did you mean t02?"},
        Slip{"Nothing", "# parts: t01=", "found 't01='"},
        Slip{"MeasuredBy", "# measured_by: x laser", "found 'x', expected words such as x=laser"},
        Slip{"Count", "# measured_by: x=laser*many", "found 'x=laser*many'"},
        Slip{"BlankAfterComma", "# measured_by: x=a*1, b*2", "found 'b*2'"},
        Slip{"Overruns", "# overruns: Yes", "found 'Yes', expected yes or no"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(Metadata, IsReadWhereItIsWellWritten) {
  for (const char* line :
       {"# parts: t01=robot t02=air", "# parts: t01=robot", "# overruns: no", "# overruns: yes",
        "# measured_by: x=laser-1*120,laser-2*80 ma.rx=level+collimator", "# note: t01 = robot"})
    EXPECT_TRUE(read_with(line)) << line;
  // A file whose column was taken away keeps its other parts.
  const auto fewer = read_with("# parts: t01=robot t02=robot t03=instrument");
  ASSERT_TRUE(fewer) << fewer.error().message;
  EXPECT_EQ(parts_from(fewer->metadata).size(), 3u);
}

}  // namespace
}  // namespace driftwise::formats
