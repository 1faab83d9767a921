// Any text as a token, a role of a certificate, a role's name, a tag of a run: refused with a
// reason that holds nothing of a secret, or taken and written back.

#include <cstdint>
#include <cstdlib>
#include <string>

#include "server/access/role.h"
#include "server/access/token.h"
#include "server/core/records/run_metadata.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto parts = access::token_parts(text);
  if (parts && access::token_text(*parts) != text) std::abort();
  if (!parts && parts.error().reason.empty()) std::abort();
  if (!parts && size > 16 && parts.error().message.find(text) != std::string::npos) std::abort();
  if (const auto role = access::role_from_uri(text);
      role && std::string(access::kRoleUri) + std::string(access::to_string(*role)) != text)
    std::abort();
  if (const auto role = access::role_from(text); role && access::to_string(*role) != text)
    std::abort();
  const auto item = metadata_item_from(text);
  if (!item && item.error().reason.empty()) std::abort();
  static_cast<void>(metadata_from_lines(text));
  return 0;
}
