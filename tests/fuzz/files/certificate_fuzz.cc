// Any file as a certificate, a key or a list of revoked certificates: an error with a reason, or
// facts. The files are in memory.

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "server/access/certificate.h"
#include "server/access/revoked_certificates.h"
#include "server/access/role.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise::access;
  static const int file = ::memfd_create("certificate", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  if (::ftruncate(file, 0) != 0 || ::pwrite(file, data, size, 0) != static_cast<::ssize_t>(size))
    std::abort();
  const auto facts = read_certificate(path);
  if (!facts && facts.error().reason.empty()) std::abort();
  if (facts) {
    for (const auto& uri : facts->uris) static_cast<void>(role_from_uri(uri));
    static_cast<void>(expiry_warning(path, *facts, 1'795'248'000));
  }
  const auto pair = check_certificate(path, path, 1'795'248'000);
  if (!pair && pair.error().reason.empty()) std::abort();
  const auto list = RevokedCertificates::check(path, path, 1'795'248'000);
  if (!list && list.error().reason.empty()) std::abort();
  return 0;
}
