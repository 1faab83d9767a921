#include "server/application/motion/lease_book.h"

#include <fmt/format.h>

#include <random>
#include <utility>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr auto kShortest = std::chrono::seconds(1);
constexpr auto kLongest = std::chrono::hours(1);

std::string random_token() {
  std::random_device source;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", source(), source(), source(), source());
}

}  // namespace

struct LeaseBook::Entry {
  Lease lease;
};

LeaseBook::LeaseBook(std::function<UtcTime(CellTime)> utc) : utc_(std::move(utc)) {}
LeaseBook::~LeaseBook() = default;

std::string LeaseBook::text_of(CellTime instant) const {
  return utc_ ? to_iso8601(utc_(instant)) : to_iso8601(instant);
}

Result<Lease> LeaseBook::take(const Caller& caller, Nanoseconds duration, const std::string& token,
                              CellTime now) {
  if (duration < kShortest || duration > kLongest)
    return fail(
        ErrorCode::invalid_argument, reasons::kLeaseDuration,
        fmt::format("a lease of {:g} s was asked for: it lasts 1 s to 3600 s and may be renewed",
                    seconds_from(duration)));
  if (!token.empty()) {
    DRIFTWISE_RETURN_IF_ERROR(check(token, now));
    entry_->lease.until = now + duration;
    return entry_->lease;
  }
  if (entry_ && entry_->lease.until > now)
    return fail(
        ErrorCode::permission_denied, reasons::kLeaseHeld,
        fmt::format("{} ({}) holds the lease to move until {}: wait, ask for it to be given up, or "
                    "show its token (--lease-token)",
                    entry_->lease.holder, entry_->lease.peer, text_of(entry_->lease.until)));
  entry_ = std::make_unique<Entry>(
      Entry{Lease{random_token(), caller.name, caller.peer, now + duration}});
  return entry_->lease;
}

Result<void> LeaseBook::give_up(const std::string& token, CellTime now) {
  if (!entry_ || entry_->lease.token != token)
    return fail(ErrorCode::permission_denied, reasons::kLeaseUnknown,
                "this token holds no lease: nothing to give up");
  static_cast<void>(now);
  entry_.reset();
  return {};
}

void LeaseBook::end(std::string why) {
  if (!entry_) return;
  ended_token_ = std::move(entry_->lease.token);
  ended_why_ = std::move(why);
  entry_.reset();
}

Result<void> LeaseBook::check(const std::string& token, CellTime now) const {
  if (token.empty())
    return fail(ErrorCode::permission_denied, reasons::kLeaseRequired,
                "what moves the robot needs the lease: take it first and state its token");
  if (token == ended_token_)
    return fail(ErrorCode::aborted, reasons::kStoppedMeanwhile,
                fmt::format("{}: that ended this lease. See that nobody is in the cell, and take a "
                            "new one",
                            ended_why_));
  if (!entry_ || entry_->lease.token != token) {
    if (const auto other = present(now))
      return fail(ErrorCode::permission_denied, reasons::kLeaseHeld,
                  fmt::format("{} ({}) holds the lease to move until {}", other->holder,
                              other->peer, text_of(other->until)));
    return fail(ErrorCode::permission_denied, reasons::kLeaseUnknown,
                "this token holds no lease (given up, taken over, or from before a restart): take "
                "a new one");
  }
  if (entry_->lease.until <= now)
    return fail(ErrorCode::permission_denied, reasons::kLeaseExpired,
                fmt::format("the lease of {} ran out at {}: take it again", entry_->lease.holder,
                            text_of(entry_->lease.until)));
  return {};
}

std::optional<Lease> LeaseBook::present(CellTime now) const {
  if (!entry_ || entry_->lease.until <= now) return std::nullopt;
  auto lease = entry_->lease;
  lease.token.clear();
  return lease;
}

}  // namespace driftwise::application
