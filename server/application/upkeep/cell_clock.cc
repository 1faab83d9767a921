#include "server/application/upkeep/cell_clock.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr auto kLongestTimer = std::chrono::seconds(1);

}  // namespace

Result<std::unique_ptr<CellClock>> CellClock::open(asio::any_io_executor executor,
                                                   const ClockDescription& description,
                                                   ComputerClock computer) {
  auto file = description.file.empty() ? Result<std::unique_ptr<ClockFile>>(
                                             fail(ErrorCode::not_found, reasons::kNoClockFile, ""))
                                       : ClockFile::open(description.file, computer.boot);
  if (!file && file.error().code == ErrorCode::not_found && description.speed == 1.0) {
    const auto boot = computer.boot_ns();
    const ClockAnchor anchor{boot, boot + application::wall_ahead_ns(computer), 1.0};
    return std::unique_ptr<CellClock>(
        new CellClock(std::move(executor), nullptr, anchor, std::move(computer)));
  }
  if (description.file.empty())
    return fail(
        ErrorCode::invalid_argument, reasons::kClockSpeed,
        fmt::format("[clock] speed = {:g} needs [clock] file, shared with the simulated cell",
                    description.speed));
  DRIFTWISE_RETURN_IF_ERROR(file);
  const auto anchor = (*file)->read();
  std::unique_ptr<CellClock> clock(
      new CellClock(std::move(executor), std::move(*file), anchor, std::move(computer)));
  // A daemon that ended while it gave way left a lower speed behind.
  if (anchor.speed != description.speed) clock->change_speed(description.speed);
  clock->governor_ = SpeedGovernor(description.speed);
  return clock;
}

CellClock::CellClock(asio::any_io_executor executor, std::unique_ptr<ClockFile> file,
                     ClockAnchor anchor, ComputerClock computer)
    : executor_(std::move(executor)),
      computer_(std::move(computer)),
      file_(std::move(file)),
      governor_(anchor.speed),
      anchor_(anchor),
      began_ns_(anchor.cell_from_boot(computer_.boot_ns())) {}

CellClock::~CellClock() = default;

Stamp CellClock::now() const {
  const CellTime now{anchor_.read().cell_from_boot(computer_.boot_ns())};
  return {now, now.utc_ns - began_ns_};
}

void CellClock::begin_at(CellTime now, CellTime not_before) {
  if (file_) return;
  const auto begin = std::max(now.utc_ns, not_before.utc_ns + 1'000'000);
  anchor_.write({computer_.boot_ns(), begin, 1.0});
  began_ns_ = begin;
}

double CellClock::speed() const { return anchor_.read().speed; }

Awaitable<void> CellClock::sleep_until(CellTime instant) {
  Sleeper sleeper{asio::steady_timer(executor_)};
  const auto place = sleepers_.insert(sleepers_.end(), &sleeper);
  struct Leave {
    std::list<Sleeper*>& from;
    std::list<Sleeper*>::iterator place;
    ~Leave() { from.erase(place); }
  } leave{sleepers_, place};

  while (true) {
    const auto left = instant - now().utc;
    if (left.count() <= 0) co_return;
    const auto wall = std::chrono::nanoseconds(
        static_cast<std::int64_t>(static_cast<double>(left.count()) / speed()) + 1);
    sleeper.arm_again = false;
    sleeper.timer.expires_after(std::min<std::chrono::nanoseconds>(wall, kLongestTimer));
    const auto [error] = co_await sleeper.timer.async_wait(asio::as_tuple(asio::use_awaitable));
    if (error && !sleeper.arm_again) co_return;  // cancelled
  }
}

std::chrono::nanoseconds CellClock::wall_from(Nanoseconds cell,
                                              std::chrono::nanoseconds floor) const {
  const auto wall = std::chrono::nanoseconds(
      static_cast<std::int64_t>(static_cast<double>(cell.count()) / speed()));
  return std::max(wall, floor);
}

void CellClock::report_lag(Nanoseconds lag) {
  if (const auto changed = governor_.report(lag, computer_.boot_ns())) {
    spdlog::info("cell time runs at {:.1f}x now (lag {:.2f} s of cell time)", *changed,
                 seconds_from(lag));
    change_speed(*changed);
  }
}

void CellClock::change_speed(double speed) {
  // Time itself does not jump, only its rate.
  const auto boot = computer_.boot_ns();
  const ClockAnchor changed{boot, anchor_.read().cell_from_boot(boot), speed, computer_.wall_ns()};
  anchor_.write(changed);
  if (file_) file_->write(changed);
  for (auto* sleeper : sleepers_) {
    sleeper->arm_again = true;
    sleeper->timer.cancel();
  }
}

}  // namespace driftwise::application
