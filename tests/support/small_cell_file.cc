#include "tests/support/small_cell_file.h"

#include <stdexcept>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"

namespace driftwise::tests {

std::string small_cell_text(const std::string& database) {
  std::string text = "[cell]\nname = \"small\"\ndatabase = \"" + database +
                     "\"\n\n"
                     "[run]\nsettle_s = 1\nquiet_nm = 80\n\n"
                     "[checks]\ndrift_window_s = 20\nstabiliser_wait_s = 600\n\n"
                     "[[device]]\nid = \"axis\"\nkind = \"pi-gcs\"\naddress = \"127.0.0.1:1\"\n"
                     "  [[device.axis]]\n  channel = \"q1_mm\"\n  device_axis = \"X\"\n"
                     "  min_mm = -5\n  max_mm = 5\n  u_scale_nm = 20\n\n"
                     "[[device]]\nid = \"scanner\"\nkind = \"keithley-2701\"\n"
                     "address = \"127.0.0.1:2\"\nperiod_s = 5\n";
  for (int n = 1; n <= 5; ++n)
    text += "  [[device.probe]]\n  channel = \"t0" + std::to_string(n) +
            "_degC\"\n  input = " + std::to_string(100 + n) + "\n  part = \"" +
            (n == 5 ? "instrument" : "robot") + "\"\n  u_k = 0.005\n";
  return text +
         "\n[[device]]\nid = \"laser-x\"\nkind = \"interferometer-adapter\"\n"
         "address = \"127.0.0.1:3\"\nperiod_s = 2\nlength = \"x_mm\"\n\n"
         "[[device]]\nid = \"support\"\nkind = \"watlow-ez-zone\"\naddress = \"127.0.0.1:4\"\n"
         "period_s = 5\n";
}

CellDescription cell_of(const std::string& text) {
  auto cell = formats::parse_cell_file(text, "/dev/shm/cell.toml", drivers::all_devices());
  if (!cell) throw std::runtime_error(cell.error().message);
  return std::move(*cell);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("the cell file has no '" + from + "'");
  return text.replace(at, from.size(), to);
}

}  // namespace driftwise::tests
