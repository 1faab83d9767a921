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

std::shared_ptr<SharedLine> line_at(const Address& address, asio::any_io_executor executor,
                                    SharedByAddress* shared) {
  const auto make = [&] { return std::make_shared<SharedLine>(executor); };
  const auto* serial = std::get_if<SerialAddress>(&address);
  if (!serial || !shared) return make();
  return shared->find_or<SharedLine>(shared_key(address, serial->path), make);
}

}  // namespace driftwise::transport
