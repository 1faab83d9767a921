#include "server/application/notify/life_signs.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "server/application/plumbing/run_on.h"

namespace driftwise::application {
namespace {

Result<std::string> report(Notifier* notifier, const WatchdogRules& rules, const LifeSign& sign) {
  return notifier->report(rules, sign);
}

}  // namespace

LifeSigns::LifeSigns(asio::any_io_executor executor, Parts parts, Rules rules, Run run)
    : parts_(std::move(parts)), rules_(std::move(rules)), run_(std::move(run)), timer_(executor) {}

void LifeSigns::start() {
  if (parts_.notifier != nullptr && !rules_.watchdog.url.empty())
    parts_.tasks.spawn(send_for_ever());
}

void LifeSigns::shut_down() {
  ending_ = true;
  timer_.cancel();
}

// Parts of the record that cannot be read are left out: the cell lives all the same.
Awaitable<LifeSign> LifeSigns::sign() {
  constexpr int kMost = 1000;
  LifeSign sign;
  sign.cell = rules_.cell;
  sign.version = rules_.version;
  sign.at = parts_.clock.utc(parts_.clock.now().utc);
  sign.every_s = rules_.watchdog.every_s;
  run_(sign);
  const auto alarms = co_await parts_.reader.alarms().alarms(false, kMost);
  if (alarms)
    sign.alarms = std::ranges::count_if(*alarms, [](const AlarmRecord& alarm) {
      return alarm.acknowledged.utc_ns == 0 && alarm.shelved_until.utc_ns == 0;
    });
  if (parts_.unstored) sign.alarms += std::ssize(parts_.unstored());
  const auto head = co_await parts_.reader.audit().head();
  if (head) sign.head = *head;
  co_return sign;
}

Awaitable<void> LifeSigns::send_for_ever() {
  using Steady = std::chrono::steady_clock;
  const auto every = std::chrono::duration_cast<Steady::duration>(
      std::chrono::duration<double>(rules_.watchdog.every_s));
  for (auto next = Steady::now(); !ending_; next = std::max(next + every, Steady::now())) {
    timer_.expires_at(next);
    co_await timer_.async_wait(asio::as_tuple(asio::use_awaitable));
    if (ending_) co_return;
    auto making = sign();
    const LifeSign made = co_await std::move(making);
    const auto said =
        co_await run_on(parts_.threads, &report, parts_.notifier, rules_.watchdog, made);
    if (ending_) co_return;
    answer_ = said ? *said : said.error().message;
    const CellTime now = parts_.clock.now().utc;
    if (said) {
      delivered_ = now;
      failing_since_ = {};
      failing_from_.reset();
    } else if (!failing_from_) {
      spdlog::warn("a sign of life to {}: {}", rules_.watchdog.url, answer_);
      failing_since_ = now;
      failing_from_ = Steady::now();
    }
  }
}

std::optional<ReceiverStatus> LifeSigns::status() const {
  if (rules_.watchdog.url.empty()) return std::nullopt;
  return ReceiverStatus{
      "watchdog", "sign of life to " + rules_.watchdog.url, 0, delivered_, failing_since_, answer_};
}

std::optional<AlarmCondition> LifeSigns::condition() const {
  if (!failing_from_ || std::chrono::steady_clock::now() - *failing_from_ < kFailing)
    return std::nullopt;
  return AlarmCondition{
      AlarmLevel::warning, "watchdog.unreached", "watchdog",
      fmt::format("no sign of life has reached {} since {}: {}; it will take the "
                  "cell for silent",
                  rules_.watchdog.url, to_iso8601(parts_.clock.utc(failing_since_)), answer_)};
}

}  // namespace driftwise::application
