#include "server/application/cell_clock.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace driftwise::application {
namespace {

std::int64_t wall_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}
std::int64_t steady_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

Result<std::unique_ptr<CellClock>> CellClock::open(asio::any_io_executor executor,
                                                   const ClockDescription& description) {
  auto file =
      description.file.empty()
          ? Result<std::unique_ptr<ClockFile>>(fail(ErrorCode::not_found, "NO_CLOCK_FILE", ""))
          : ClockFile::open(description.file);
  if (!file && file.error().code == ErrorCode::not_found && description.speed == 1.0) {
    const auto wall = wall_ns();
    return std::unique_ptr<CellClock>(
        new CellClock(std::move(executor), nullptr, {wall, wall, 1.0}));
  }
  if (description.file.empty())
    return fail(
        ErrorCode::invalid_argument, "CLOCK_SPEED",
        fmt::format("[clock] speed = {:g} needs [clock] file, shared with the simulated cell",
                    description.speed));
  if (!file) return tl::unexpected(file.error());
  const auto anchor = (*file)->read();
  std::unique_ptr<CellClock> clock(new CellClock(std::move(executor), std::move(*file), anchor));
  // A daemon that ended while it gave way left a lower speed behind.
  if (anchor.speed != description.speed) clock->change_speed(description.speed);
  clock->governor_ = SpeedGovernor(description.speed);
  return clock;
}

CellClock::CellClock(asio::any_io_executor executor, std::unique_ptr<ClockFile> file,
                     ClockAnchor anchor)
    : executor_(std::move(executor)),
      file_(std::move(file)),
      governor_(anchor.speed),
      anchor_(anchor),
      monotonic_({steady_ns(), 0, anchor.speed}) {}

CellClock::~CellClock() = default;

Stamp CellClock::now() const {
  return {CellTime{anchor_.read().cell_from_wall(wall_ns())},
          monotonic_.read().cell_from_wall(steady_ns())};
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
    sleeper.timer.expires_after(wall);
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
  if (const auto changed = governor_.report(lag, steady_ns())) {
    spdlog::info("cell time runs at {:.1f}x now (lag {:.2f} s of cell time)", *changed,
                 seconds_from(lag));
    change_speed(*changed);
  }
}

void CellClock::change_speed(double speed) {
  // Time itself does not jump, only its rate.
  const auto steady = steady_ns();
  monotonic_.write({steady, monotonic_.read().cell_from_wall(steady), speed});
  const auto wall = wall_ns();
  const ClockAnchor changed{wall, anchor_.read().cell_from_wall(wall), speed};
  anchor_.write(changed);
  if (file_) file_->write(changed);
  for (auto* sleeper : sleepers_) {
    sleeper->arm_again = true;
    sleeper->timer.cancel();
  }
}

}  // namespace driftwise::application
