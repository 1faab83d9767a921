// [access] of a cell file.

#include <gtest/gtest.h>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"

namespace driftwise::formats {
namespace {

Result<CellDescription> with_access(const std::string& access, const std::string& listen = "") {
  return parse_cell_file("[cell]\nname = \"small\"\ndatabase = \"small.db\"\n" + listen + access +
                             "[[device]]\nid = \"laser-x\"\nkind = \"interferometer-adapter\"\n"
                             "address = \"127.0.0.1:1\"\nlength = \"x_mm\"\n",
                         "/cells/cell.toml", drivers::all_devices());
}

constexpr const char* kTls = "certificate = \"tls/server.pem\"\nkey = \"/keys/server.key\"\n";

TEST(CellFileAccess, LeavesLoopbackOpenWithoutTheSection) {
  const auto cell = with_access("");
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_FALSE(cell->access.configured);
  EXPECT_EQ(cell->access.loopback, LoopbackRule::open);
}

TEST(CellFileAccess, AsksForATokenWithIt) {
  const auto cell = with_access("[access]\n");
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_TRUE(cell->access.configured);
  EXPECT_EQ(cell->access.loopback, LoopbackRule::token);
  EXPECT_EQ(with_access("[access]\nloopback = \"open\"\n")->access.loopback, LoopbackRule::open);
}

TEST(CellFileAccess, FindsItsFilesFromTheFolderOfTheCellFile) {
  const auto cell = with_access(std::string("[access]\nlisten = \"0.0.0.0:50052\"\n") + kTls +
                                "authority = \"tls/authority.pem\"\n");
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->access.certificate, "/cells/tls/server.pem");
  EXPECT_EQ(cell->access.key, "/keys/server.key");
  EXPECT_EQ(cell->access.authority, "/cells/tls/authority.pem");
  EXPECT_EQ(cell->access.listen, "0.0.0.0:50052");
}

struct AccessMistake {
  const char* name;
  std::string access, listen;
  const char* reason;
  const char* sentence;
};
class CellFileAccessMistakes : public testing::TestWithParam<AccessMistake> {};
TEST_P(CellFileAccessMistakes, AreNamed) {
  const auto cell = with_access(GetParam().access, GetParam().listen);
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, GetParam().reason);
  EXPECT_NE(cell.error().message.find(GetParam().sentence), std::string::npos)
      << cell.error().message;
}
INSTANTIATE_TEST_SUITE_P(
    Table, CellFileAccessMistakes,
    testing::Values(AccessMistake{"WithoutTls", "[access]\nlisten = \"0.0.0.0:50052\"\n", "",
                                  "NEEDS_TLS", "driftwise cert init"},
                    AccessMistake{"PageWithoutTls", "[access]\nhttp = \"0.0.0.0:8443\"\n", "",
                                  "NEEDS_TLS", "http"},
                    AccessMistake{"HalfACertificate", "[access]\nkey = \"k\"\n", "", "NEEDS_TLS",
                                  "expected both"},
                    AccessMistake{"NoPort", std::string("[access]\nlisten = \"0.0.0.0\"\n") + kTls,
                                  "", "BAD_ADDRESS", "found '0.0.0.0'"},
                    AccessMistake{"Rule", "[access]\nloopback = \"closed\"\n", "", "OUT_OF_RANGE",
                                  "token, open"},
                    AccessMistake{"Key", "[access]\nlisten_tls = \"x\"\n", "", "UNKNOWN_KEY",
                                  "listen"},
                    AccessMistake{"PlainDoor", "", "listen = \"0.0.0.0:50051\"\n",
                                  "LISTEN_NOT_LOOPBACK", "[access]"}),
    [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace driftwise::formats
