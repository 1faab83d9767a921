// An inclinometer in the place of an autocollimator, on the wire: driftwise-cellsim, driftwised and
// the record.

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include "tests/support/running_cell.h"
#include "tests/support/sql_query.h"

namespace driftwise::tests {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

const fs::path kCells = fs::path(DRIFTWISE_SOURCE_DIR) / "deploy/cells";

std::string with_piece(std::string text, const std::string& from, const std::string& to,
                       const std::string& instead) {
  const auto begin = text.find(from), end = text.find(to, begin);
  if (begin == std::string::npos || end == std::string::npos)
    throw std::runtime_error("the Micro-Nano's cell file has no " + from);
  return text.replace(begin, end - begin, instead);
}

// The Micro-Nano with the inclinometer instead of its second autocollimator, as a folder of cells.
class CellWithLevel {
 public:
  CellWithLevel() {
    const fs::path from = kCells / "micro-nano", to = folder_.path();
    write_file(to / "plant.toml", read_file(from / "plant.toml"));
    write_file(
        to / "cell.toml",
        with_piece(read_file(from / "cell.toml"), "id = \"collimator-2\"", "[[device.angle]]",
                   "id = \"level\"\nkind = \"meas-dpl\"\naddress = \"127.0.0.1:50021\"\n"
                   "timeout_s = 2.0\nperiod_s = 5.0\n\n[device.options]\nreadings = 2\n\n"));
  }
  std::string name() const { return fs::relative(folder_.path(), kCells); }

 private:
  TemporaryFolder folder_;
};

TEST(InclinometerOnTheWire, IsReadAndStored) {
  const CellWithLevel files;
  RunningCell cell({.speed = 20, .cell = files.name()});
  cell.start_daemon();
  const std::string stored =
      "SELECT count(*) FROM reading JOIN device USING (device_id) WHERE device.name = 'level'";
  for (const auto end = std::chrono::steady_clock::now() + 60s;
       std::chrono::steady_clock::now() < end && count_of(cell.database(), stored) < 3;)
    std::this_thread::sleep_for(100ms);
  ASSERT_GE(count_of(cell.database(), stored), 3) << cell.daemon_log();
  const std::string value_deg = query_one(
      cell.database(),
      "SELECT rx_arcsec / 3600 FROM reading_wide WHERE device = 'level' ORDER BY 1 LIMIT 1");
  ASSERT_FALSE(value_deg.empty());
  // The mean of two readings of a thousandth of a degree.
  const double halves = std::stod(value_deg) * 2000;
  EXPECT_NEAR(halves, std::round(halves), 1e-6);
  EXPECT_LT(std::abs(halves), 1000) << "half a degree";
  const auto status = cell.cli({"status", "--json"});
  EXPECT_EQ(status.code, 0) << status.err;
  EXPECT_THAT(status.out, HasSubstr("DPL2 V1.8.0, SN:12345678"));
  EXPECT_EQ(cell.stop_daemon(), 0);
}

}  // namespace
}  // namespace driftwise::tests
