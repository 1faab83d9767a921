// Standard input and devices: a compressed table is read as it is, a stream of zero bytes is not.

#include "clients/cli/core/read_stream.h"

#include <gmock/gmock.h>

#include <sstream>

#include "clients/cli/core/console.h"

namespace driftwise::tests {
namespace {

using namespace std::string_literals;

TEST(ReadStream, TakesACompressedTableWithItsZeroBytes) {
  const std::string gzip = "\x1f\x8b\x08\0\0\0\0\0\0\x03"s + std::string(5000, '\0');
  std::istringstream stream(gzip);
  EXPECT_EQ(cli::read_stream(stream, "lab.csv.gz"), gzip);
}

TEST(ReadStream, RefusesZeroBytesThatAreNoText) {
  std::istringstream stream(std::string(5000, '\0'));
  try {
    cli::read_stream(stream, "/dev/zero");
    FAIL() << "was read";
  } catch (const cli::Failure& failure) {
    EXPECT_EQ(failure.reason, "NOT_TEXT");
    EXPECT_THAT(failure.message, testing::HasSubstr("/dev/zero"));
  }
}

}  // namespace
}  // namespace driftwise::tests
