#pragma once
// What a protocol leaves open, as the cell file's options give it: read by name, checked by value.

#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/description/cell_description.h"
#include "server/core/result.h"

namespace driftwise::transport {

// Reads DeviceDescription::options. Every getter returns its default where the option is not given
// and remembers the first problem; finish() answers it, or names an option that no getter asked for
// with the known ones.
class OptionReader {
 public:
  explicit OptionReader(const DeviceDescription& device) : device_(device) {}

  std::string text(const std::string& name, std::string fallback);
  std::string choice(const std::string& name, std::string fallback,
                     std::initializer_list<const char*> allowed);
  bool on_off(const std::string& name, bool fallback);  // "on" | "off"; also true | false
  double number(const std::string& name, double fallback, double min, double max);
  int integer(const std::string& name, int fallback, int min, int max);

  // Errors: invalid_argument, reason BAD_OPTION.
  Result<void> finish() const;

 private:
  const std::string* given(const std::string& name);
  void complain(const std::string& name, const std::string& found, const std::string& expected);

  const DeviceDescription& device_;
  std::vector<std::string> known_;
  std::optional<Error> problem_;
};

}  // namespace driftwise::transport
