// Any bytes at the watchdog's door: an error, or a sign of life that writes and reads back.

#include <cstdint>
#include <cstdlib>
#include <string>

#include "server/notify/notice_json.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const auto sign = notify::life_sign_from(std::string(reinterpret_cast<const char*>(data), size));
  if (!sign) return 0;
  const std::string written = notify::life_sign_json(*sign);
  const auto again = notify::life_sign_from(written);
  if (!again || notify::life_sign_json(*again) != written) std::abort();
  return 0;
}
