#pragma once
// The settings of one [[device]] as its kind reads them. A reader remembers the first problem of
// the whole file; its message names the file, the line, the device, the key, what was found and
// what was expected. A key that nobody asks for is refused as unknown.

#include <functional>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>

#include "server/core/channel.h"
#include "server/core/reasons.h"

namespace driftwise {

enum class Need { required, optional };

struct Range {
  double min = -std::numeric_limits<double>::max(), max = std::numeric_limits<double>::max();
  bool above_min = false;  // min itself is not allowed
};

class SettingsReader {
 public:
  virtual ~SettingsReader() = default;
  // Each leaves its argument as it is when an optional key is absent or something was wrong.
  virtual void text(const char* key, std::string& value, Need need = Need::optional) = 0;
  virtual void choice(const char* key, std::string& value,
                      std::initializer_list<std::string_view> allowed,
                      Need need = Need::optional) = 0;
  virtual void number(const char* key, double& value, Range range = {},
                      Need need = Need::optional) = 0;
  virtual void integer(const char* key, int& value, int min, int max,
                       Need need = Need::optional) = 0;
  virtual void channel(const char* key, Channel& value, Need need = Need::optional) = 0;
  // The device gives this channel, by what stands at the key. One that another device, axis or
  // probe gives already is refused, DUPLICATE_CHANNEL.
  virtual void give(const char* key, const std::string& channel) = 0;
  // Each [[device.<key>]] in turn; expects at least one (MISSING_KEY).
  virtual void each(const char* key, const std::function<void(SettingsReader&)>& read) = 0;
  // A problem at this key's value, or at the table when the key is absent.
  virtual void refuse(const char* key, Reason reason, const std::string& sentence) = 0;
};

}  // namespace driftwise
