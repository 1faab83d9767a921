#include "drivers/interferometer_adapter/adapter_codec.h"

#include <gmock/gmock.h>

namespace driftwise::adapter {
namespace {

using testing::HasSubstr;

const std::string kGood =
    "OK ch=1 n=4096 mean_nm=-12345.678 std_nm=1.25 t_air_C=20.51 t_age_s=0.4 level_pct=87 "
    "status=0x0010 "
    "t0=1795248299.123456789 t1=1795248299.5\n";

std::string with(const std::string& field, const std::string& value) {
  std::string out = kGood;
  const std::size_t at = out.find(" " + field + "=") + 1;
  const std::size_t end = out.find_first_of(" \n", at);
  return out.replace(at, end - at, value);
}

TEST(AdapterMeasurement, IsReadWithoutLossOfItsTime) {
  const auto measured = parse_measurement(kGood);
  ASSERT_TRUE(measured);
  EXPECT_EQ(measured->mean_nm, -12345.678);
  EXPECT_EQ(measured->std_nm, 1.25);
  EXPECT_EQ(measured->air_degc, 20.51);
  EXPECT_EQ(measured->status, 0x10u);
  EXPECT_EQ(measured->start.utc_ns, 1795248299'123456789);
  EXPECT_EQ(measured->end.utc_ns, 1795248299'500000000);
  EXPECT_TRUE(check_status(*measured));
}

struct Bad {
  const char *name, *field, *value, *says;
};
class BadMeasurement : public testing::TestWithParam<Bad> {};
TEST_P(BadMeasurement, NamesItsField) {
  const auto measured = parse_measurement(with(GetParam().field, GetParam().value));
  ASSERT_FALSE(measured);
  EXPECT_EQ(measured.error().reason, "BAD_REPLY");
  EXPECT_THAT(measured.error().message, HasSubstr(GetParam().says));
}
INSTANTIATE_TEST_SUITE_P(Table, BadMeasurement,
                         testing::Values(Bad{"missing", "mean_nm", "", "mean_nm"},
                                         Bad{"no_number", "mean_nm", "mean_nm=x", "mean_nm"},
                                         Bad{"not_finite", "mean_nm", "mean_nm=nan", "mean_nm"},
                                         Bad{"unit_glued", "std_nm", "std_nm=1nm", "std_nm"},
                                         Bad{"negative_spread", "std_nm", "std_nm=-1", "negative"},
                                         Bad{"decimal_status", "status", "status=16", "status"},
                                         Bad{"time_backwards", "t1", "t1=1795248299.1", "t1"},
                                         Bad{"no_time", "t0", "t0=now", "t0"},
                                         Bad{"time_in_year_9999", "t0", "t0=253370764800", "t0"},
                                         Bad{"not_ascii", "ch", "ch=\xb5", "ch"}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(AdapterReply, ThatIsNeitherOkNorErrIsDataLoss) {
  for (const char* reply : {"", "\n", "OKAY", "ERR", "ERR x", "1795248299"}) {
    EXPECT_EQ(parse_measurement(reply).error().reason, "BAD_REPLY") << reply;
    EXPECT_EQ(parse_ok(reply).error().reason, "BAD_REPLY") << reply;
    EXPECT_EQ(parse_identity(reply).error().reason, "BAD_REPLY") << reply;
  }
  EXPECT_EQ(parse_ok(kGood).error().reason, "BAD_REPLY")
      << "a late measurement is no acknowledgement";
  EXPECT_EQ(parse_measurement("OK\n").error().reason, "BAD_REPLY");
}

TEST(AdapterErrors, BecomeOurs) {
  EXPECT_EQ(parse_ok("ERR 3 beam break\n").error().reason, "BEAM_LOST");
  EXPECT_EQ(parse_ok("ERR 6 laser\n").error().reason, "LASER_UNSTABLE");
  EXPECT_EQ(parse_ok("ERR 4 timeout\n").error().code, ErrorCode::deadline_exceeded);
  EXPECT_EQ(parse_ok("ERR 5 overflow\n").error().code, ErrorCode::data_loss);
  EXPECT_EQ(parse_ok("ERR 77 what\n").error().reason, "REFUSED");
}

TEST(AdapterStatus, SaysWhetherTheLengthCanBeTrusted) {
  const auto reason = [](std::uint32_t status) {
    Measurement measurement;
    measurement.status = status;
    const auto good = check_status(measurement);
    return good ? "" : good.error().reason;
  };
  EXPECT_EQ(reason(0x10), "");
  EXPECT_EQ(reason(0x00), "LASER_UNSTABLE");
  EXPECT_EQ(reason(0x30), "LASER_UNSTABLE");
  EXPECT_EQ(reason(0x11), "BEAM_LOST");
  EXPECT_EQ(reason(0x12), "LOW_LEVEL");
  EXPECT_EQ(reason(0x110), "VALUES_LOST");
  EXPECT_EQ(reason(0x210), "VALUES_LOST");
  EXPECT_EQ(reason(0x8010), "BAD_REQUEST");
}

TEST(AdapterIdentity, IsMakerModelSerialAndChannels) {
  const auto identity = parse_identity("OK SIOS SP-2000 0471 ch=3\n");
  EXPECT_EQ(identity->text, "SIOS SP-2000 0471");
  EXPECT_EQ(identity->channels, 3);
  EXPECT_FALSE(parse_identity("OK ch=3"));
  EXPECT_FALSE(parse_identity("OK SIOS ch=0"));
}

TEST(UnixTime, KeepsEveryNanosecond) {
  EXPECT_EQ(parse_unix_time("0")->utc_ns, 0);
  EXPECT_EQ(parse_unix_time("1.5")->utc_ns, 1'500'000'000);
  EXPECT_EQ(parse_unix_time("1.0000000019")->utc_ns, 1'000'000'001);
  for (const char* bad : {"", ".", "1.", "-1", "1e9", "9223372036", "1.5x", " 1"})
    EXPECT_FALSE(parse_unix_time(bad)) << bad;
}

}  // namespace
}  // namespace driftwise::adapter
