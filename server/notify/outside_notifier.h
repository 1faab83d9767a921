#pragma once

#include <atomic>

#include "server/core/ports/outside/notifier.h"

namespace driftwise::notify {

// Webhooks, mails and commands as they leave the machine. Any thread.
class OutsideNotifier final : public Notifier {
 public:
  Result<Delivery> tell(const ReceiverDescription& receiver, const Notice& notice) override;
  Result<std::string> report(const WatchdogRules& watchdog, const LifeSign& sign) override;
  void shut_down() override { stop_ = true; }

 private:
  std::atomic<bool> stop_{false};
};

}  // namespace driftwise::notify
