#include "server/formats/size_text.h"

#include <gtest/gtest.h>

namespace driftwise::formats {
namespace {

TEST(SizeText, SaysALengthAtItsSize) {
  EXPECT_EQ(size_text(7.568, "nm"), "7.568 nm");
  EXPECT_EQ(size_text(-131.42, "nm"), "-131.4 nm");
  EXPECT_EQ(size_text(0, "nm"), "0 nm");
  EXPECT_EQ(size_text(9999.4, "nm"), "9999 nm");
  EXPECT_EQ(size_text(9999.6, "nm"), "10 um");
  EXPECT_EQ(size_text(309282.1, "nm"), "309.3 um");
  EXPECT_EQ(size_text(999.6e3, "nm"), "0.9996 mm");
  EXPECT_EQ(size_text(6199809.9, "nm"), "6.2 mm");
}

TEST(SizeText, KeepsAUnitThatIsNoLength) {
  EXPECT_EQ(size_text(12345.6, "arcsec"), "1.23e+04 arcsec");
}

}  // namespace
}  // namespace driftwise::formats
