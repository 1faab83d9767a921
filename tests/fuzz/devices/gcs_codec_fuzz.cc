// Whatever a PI GCS controller sends: framing and every parser of a reply.

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "drivers/pi_gcs/gcs_codec.h"
#include "drivers/transport/escape.h"
#include "drivers/transport/framing.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const auto framing : {transport::gcs_reply, transport::line_reply}) {
    for (std::string_view rest = bytes; !rest.empty();) {
      const std::size_t length = framing(rest);
      if (length == transport::kIncomplete) break;
      if (length == 0 || length > rest.size()) std::abort();
      rest.remove_prefix(length);
    }
  }
  static const std::vector<std::string> kAxes{"X", "Y"};
  if (const auto values = gcs::parse_axis_values(bytes, kAxes)) {
    for (const double value : *values)
      if (!std::isfinite(value)) std::abort();
    // What was read is written and read back exactly.
    std::string again;
    for (std::size_t i = 0; i < kAxes.size(); ++i) {
      const std::string one =
          gcs::encode_move(std::span(&kAxes[i], 1), std::span(&(*values)[i], 1));
      again += kAxes[i] + "=" + one.substr(6, one.size() - 7) + " \n";
    }
    if (const auto twice = gcs::parse_axis_values(again, kAxes); !twice || *twice != *values)
      std::abort();
  }
  (void)gcs::parse_axis_flags(bytes, kAxes);
  (void)gcs::parse_axis_names(bytes);
  (void)gcs::parse_hex(bytes);
  if (const auto number = gcs::parse_error_number(bytes)) (void)gcs::refusal(*number, "MOV");
  (void)transport::escaped(bytes);
  return 0;
}
