#pragma once
// The devices of a cell file that one scanner measures for, and its connection, which is made when
// the first of them uses it. Executor's thread.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/keithley_2701/scanner.h"

namespace driftwise::keithley {

class ScannerShare {
 public:
  ScannerShare(transport::Address address, asio::any_io_executor executor, Clock& clock)
      : address_(std::move(address)), executor_(std::move(executor)), clock_(clock) {}

  // All devices first, then scanner(). Errors: invalid_argument; BAD_OPTION, an option of the
  // connection that another device states otherwise; BAD_PROBES, an input that is outside 101 ..
  // 599, or that another device has.
  Result<void> add(const DeviceDescription& device, ScanList list);

  // The connection's own options and time-out are those of the device with thermometers, or of the
  // first one; what the others state goes over its defaults.
  Scanner& scanner();
  std::size_t list_of(const std::string& device) const;

 private:
  const transport::Address address_;
  asio::any_io_executor executor_;
  Clock& clock_;
  std::optional<DeviceDescription> device_;
  std::map<std::string, std::string> stated_;  // options of the connection
  std::map<std::string, std::string> who_;     // states them, by option
  std::vector<ScanList> lists_;
  std::unique_ptr<Scanner> scanner_;
};

}  // namespace driftwise::keithley
