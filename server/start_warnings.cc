#include "server/start_warnings.h"

#include <spdlog/spdlog.h>

#include <chrono>

#include "server/access/certificate.h"
#include "server/notify/secret_file.h"

namespace driftwise {

void warn_of_certificate(const AccessDescription& access) {
  if (!access.tls()) return;
  const auto now_utc_s = std::chrono::duration_cast<std::chrono::seconds>(
      std::chrono::system_clock::now().time_since_epoch());
  const auto good = access::check_certificate(access.certificate, access.key, now_utc_s.count());
  if (!good) spdlog::warn("{}", good.error().message);
}

void warn_of_secrets(const std::vector<ReceiverDescription>& receivers,
                     const WatchdogRules& watchdog) {
  for (const auto& receiver : receivers)
    for (const auto& path : {receiver.token_file, receiver.password_file}) {
      if (path.empty()) continue;
      const auto secret = notify::read_secret(path);
      if (!secret)
        spdlog::warn("receiver {} cannot be told: {}", receiver.name, secret.error().message);
    }
  if (watchdog.token_file.empty()) return;
  if (const auto secret = notify::read_secret(watchdog.token_file); !secret)
    spdlog::warn("the watchdog's other side cannot be told: {}", secret.error().message);
}

}  // namespace driftwise
