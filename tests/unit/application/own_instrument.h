#pragma once
// An instrument of a test's own in the small world: says what the test's function says, after the
// time that a reading takes.

#include <functional>
#include <utility>

#include "server/core/try.h"
#include "tests/support/small_world.h"

namespace driftwise::tests {

class OwnInstrument : public Instrument {
 public:
  using Values = std::function<std::vector<ChannelValue>()>;
  OwnInstrument(VirtualTime& time, DeviceDescription description, double reading_s, Values values)
      : time_(time),
        description_(std::move(description)),
        reading_s_(reading_s),
        values_(std::move(values)) {}
  const DeviceDescription& description() const override { return description_; }
  DeviceHealth health() const override {
    DeviceHealth health;
    health.link = LinkState::connected;
    return health;
  }
  Awaitable<Result<void>> prepare() override { co_return Result<void>{}; }
  void close() override {}
  Awaitable<Result<Reading>> read() override {
    Reading reading{description_.id, time_.now().utc, {}, ++sequence_, values_()};
    co_await time_.sleep_until(reading.start + nanoseconds_from_s(reading_s_));
    reading.end = time_.now().utc;
    co_return reading;
  }
  Awaitable<Result<void>> zero() override {
    co_return fail(ErrorCode::failed_precondition, "NO_ZERO", "it has no zero");
  }

 protected:
  VirtualTime& time_;

 private:
  DeviceDescription description_;
  double reading_s_;
  Values values_;
  std::int64_t sequence_ = 0;
};

// Of the axis, mm; none: it is on its way.
inline std::optional<double> standing_at_mm(const SmallWorld& world, const VirtualTime& time) {
  if (time.now().utc.utc_ns < world.move_end_ns) return std::nullopt;
  return world.to_mm;
}

}  // namespace driftwise::tests
