#include "drivers/keithley_2701/platinum_resistance.h"
#include "drivers/keithley_2701/scanned_device.h"
#include "server/core/try.h"

namespace driftwise::keithley {

Awaitable<Result<void>> Thermometers::zero() {
  co_return transport::no_zero(device_, "a scanner has no zero");
}

Awaitable<Result<Reading>> Thermometers::read() {
  DRIFTWISE_CO_TRY(const auto scanned, co_await scan());
  Reading out = reading_of(scanned);
  for (const auto& probe : device_.probes())
    out.values.push_back(
        {probe.channel.name(),
         platinum::degc_from_ohm(scanned.value(probe.input),
                                 {probe.r0_ohm, probe.a_per_degc, probe.b_per_degc2})});
  co_return out;
}

}  // namespace driftwise::keithley
