#include "drivers/transport/shared_line.h"

#include <filesystem>

#include "drivers/transport/address_key.h"

namespace driftwise::transport {

std::string shared_key(const Address& address, const std::string& text) {
  const auto* serial = std::get_if<SerialAddress>(&address);
  if (!serial) return text;
  if (auto key = serial_key(serial->path); !key.empty()) return key;
  // Not plugged in yet: links to it are told from one another by where they lead.
  std::error_code error;
  const auto path = std::filesystem::weakly_canonical(serial->path, error);
  return "serial:" + (error ? serial->path : path.string());
}

std::shared_ptr<SharedLine> SharedLines::at(const std::string& key) {
  auto& place = lines_[key];
  if (auto found = place.lock()) return found;
  auto made = std::make_shared<SharedLine>(executor_);
  place = made;
  return made;
}

std::shared_ptr<SharedLines> lines_of(asio::any_io_executor executor, SharedByAddress* shared) {
  const auto make = [&] { return std::make_shared<SharedLines>(executor); };
  return shared ? shared->find_or<SharedLines>("every line", make) : make();
}

const std::string& LineKey::now(std::string peer_key) {
  if (!peer_key.empty()) {
    key_ = std::move(peer_key);
  } else if (key_.empty() || std::holds_alternative<SerialAddress>(address_)) {
    key_ = shared_key(address_, text_);
  }
  return key_;
}

}  // namespace driftwise::transport
