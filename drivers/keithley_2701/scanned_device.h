#pragma once
// A device of the cell file behind a scanner's shared connection: everything but its reading.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/keithley_2701/scanner_share.h"
#include "server/core/ports/instrument.h"

namespace driftwise::keithley {

class ScannedDevice : public Instrument {
 public:
  const DeviceDescription& description() const override { return device_; }
  DeviceHealth health() const override { return share_->scanner().health(); }
  std::vector<std::string> recent_exchanges() const override {
    return share_->scanner().recent_exchanges();
  }
  Awaitable<Result<void>> prepare() override { return share_->scanner().prepare(); }
  void close() override { share_->scanner().close(); }

 protected:
  ScannedDevice(DeviceDescription device, std::shared_ptr<ScannerShare> share)
      : device_(std::move(device)), share_(std::move(share)) {}

  Awaitable<Result<Scan>> scan() { return share_->scanner().scan(share_->list_of(device_.id)); }
  // Without values.
  Reading reading_of(const Scan& scan) {
    return {device_.id, scan.start, scan.end, ++sequence_, {}};
  }

  const DeviceDescription device_;

 private:
  std::shared_ptr<ScannerShare> share_;
  std::int64_t sequence_ = 0;
};

// pt1000 in four-wire ohms.
class Thermometers final : public ScannedDevice {
 public:
  Thermometers(DeviceDescription device, std::shared_ptr<ScannerShare> share)
      : ScannedDevice(std::move(device), std::move(share)) {}
  Awaitable<Result<Reading>> read() override;
  Awaitable<Result<void>> zero() override;  // NO_ZERO
};

}  // namespace driftwise::keithley
