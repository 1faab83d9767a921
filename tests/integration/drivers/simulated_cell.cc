#include "tests/integration/drivers/simulated_cell.h"

#include <time.h>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"

namespace driftwise::tests {
namespace {

constexpr const char* kProgram = DRIFTWISE_BIN_DIR "/driftwise-cellsim";

template <class T>
T value_at(const std::string& bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

SharedClock::SharedClock(const std::string& clock_file) {
  const std::string bytes = read_file(clock_file);
  if (bytes.size() != 64 || !bytes.starts_with("DWCLOCK2"))
    throw std::runtime_error(clock_file + " is no clock file");
  anchor_boot_ns_ = value_at<std::int64_t>(bytes, 16);
  anchor_cell_ns_ = value_at<std::int64_t>(bytes, 24);
  speed_ = value_at<double>(bytes, 32);
}

Stamp SharedClock::now() const {
  timespec time{};
  ::clock_gettime(CLOCK_BOOTTIME, &time);
  const std::int64_t boot = std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
  const auto since =
      static_cast<std::int64_t>(static_cast<double>(boot - anchor_boot_ns_) * speed_);
  return {CellTime{anchor_cell_ns_ + since}, since};
}

Awaitable<void> SharedClock::sleep_until(CellTime instant) {
  asio::steady_timer timer(co_await asio::this_coro::executor);
  timer.expires_after(wall_from(instant - now().utc, std::chrono::nanoseconds(0)));
  (void)co_await timer.async_wait(asio::as_tuple(asio::use_awaitable));
}

std::chrono::nanoseconds SharedClock::wall_from(Nanoseconds cell,
                                                std::chrono::nanoseconds floor) const {
  const auto wall = static_cast<std::int64_t>(static_cast<double>(cell.count()) / speed_);
  return std::max(std::chrono::nanoseconds(wall), floor);
}

bool SimulatedCell::available() { return std::filesystem::exists(kProgram); }

SimulatedCell::SimulatedCell(const std::vector<std::string>& settings, double speed,
                             const std::string& cell) {
  const std::string files = DRIFTWISE_SOURCE_DIR "/deploy/cells/" + cell + "/";
  std::vector<std::string> arguments{kProgram,       "--plant",           files + "plant.toml",
                                     "--cell",       files + "cell.toml", "--instantiate",
                                     folder_.path(), "--speed",           std::to_string(speed)};
  for (const auto& setting : settings) {
    arguments.push_back("--set");
    arguments.push_back(setting);
  }
  process_ = std::make_unique<Process>(arguments);
  const auto ready = process_->read_line(std::chrono::seconds(20));
  if (!ready || !ready->starts_with("READY "))
    throw std::runtime_error("driftwise-cellsim did not start");
  const auto json = nlohmann::json::parse(ready->substr(6));
  for (const auto& [name, value] : json.items())
    if (value.is_string()) addresses_[name] = value.get<std::string>();
  auto description = formats::read_cell_file(folder_.path() + "/cell.toml", drivers::all_devices());
  if (!description) throw std::runtime_error(description.error().message);
  description_ = std::move(*description);
  clock_ = std::make_unique<SharedClock>(folder_.path() + "/clock.state");
}

SimulatedCell::~SimulatedCell() {
  process_->signal(15);
  process_->wait(std::chrono::seconds(5));
}

DeviceDescription SimulatedCell::device(const std::string& id) const {
  return *description_.find_device(id);
}

}  // namespace driftwise::tests
