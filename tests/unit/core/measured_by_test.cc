// Which instrument measured a coordinate: the line of metadata and its weights.

#include "server/core/data/measured_by.h"

#include <gtest/gtest.h>

namespace driftwise {
namespace {

using Metadata = std::vector<std::pair<std::string, std::string>>;

TEST(MeasuredBy, ReadsBackWhatItWrote) {
  const std::vector<MeasuredBy> coordinates = {{"ma.z", {{{"probe"}}}},
                                               {"ma.rx", {{{"level", "collimator-1"}}}},
                                               {"x", {{{"laser-1"}, 120}, {{"laser-2"}, 80}}}};
  const std::string text = measured_by_text(coordinates);
  EXPECT_EQ(text, "ma.z=probe ma.rx=level+collimator-1 x=laser-1*120,laser-2*80");
  EXPECT_EQ(measured_by_from({{"cell", "c"}, {"measured_by", text}}), coordinates);
}

TEST(MeasuredBy, WeighsADeviceByItsShareOfEveryValueAndOfTheRows) {
  const auto all = measured_by_from(Metadata{{"measured_by", "z=a+b*30,a*10"}});
  const auto* z = find_measured_by(all, "z");
  ASSERT_NE(z, nullptr);
  EXPECT_DOUBLE_EQ(z->weight("a"), (30 * 0.5 + 10) / 40);
  EXPECT_DOUBLE_EQ(z->weight("b"), 30 * 0.5 / 40);
  EXPECT_EQ(z->weight("c"), 0);
  EXPECT_EQ(find_measured_by(all, "x"), nullptr);
}

TEST(MeasuredBy, PassesOverWhatItCannotRead) {
  for (const char* word :
       {"", "z", "=probe", "z=", "z=a*0", "z=a*-3", "z=a*x", "z=a++b", "z=+", "z=,"})
    EXPECT_TRUE(measured_by_from(Metadata{{"measured_by", word}}).empty()) << word;
  EXPECT_EQ(measured_by_from(Metadata{{"measured_by", "z=a z=b"}}),
            (std::vector<MeasuredBy>{{"z", {{{"b"}}}}}));
  EXPECT_EQ(measured_by_text({{"z", {{{"a probe"}}}}, {"x", {{{"laser"}}}}}), "x=laser")
      << "an id that the line cannot hold is left out, never misread";
}

}  // namespace
}  // namespace driftwise
