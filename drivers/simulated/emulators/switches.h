#pragma once
// The switches of an emulated device: what a protocol leaves open, what differs between models and
// what nobody could confirm. They come from [emulator.<kind>] and [emulator.<device id>] of the
// plant file and from --set, as text; every device declares its own with a meaning, a default and
// the tag of PROTOCOLS (M, D, T, U, or "own" for what is our choice). docs/emulators.md lists them
// all (a test compares).

#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace driftwise::simulated {

struct SwitchDescription {
  std::string_view name, default_value, tag, meaning;
};

// A bad file, option or value at start-up: what() says where, what was found and what was expected.
class SetupError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Switches {
 public:
  // where: "[emulator.pi]", for messages.
  Switches(std::string where, const std::vector<SwitchDescription>& declared);
  // Throws SetupError: unknown name (with the names there are).
  void set(const std::string& name, const std::string& value);

  // Throw SetupError: the value does not read as asked.
  const std::string& text(std::string_view name) const;
  std::string escaped_text(std::string_view name) const;  // with \r \n \t \\ \xHH
  bool flag(std::string_view name) const;                 // true false on off 1 0
  double number(std::string_view name, double min, double max) const;
  int integer(std::string_view name, int min, int max) const;
  std::string choice(std::string_view name, const std::vector<std::string_view>& allowed) const;
  std::vector<std::string> words(std::string_view name) const;  // separated by commas or blanks

 private:
  [[noreturn]] void refuse(std::string_view name, const std::string& expected) const;
  std::string where_;
  std::map<std::string, std::string, std::less<>> values_;
};

}  // namespace driftwise::simulated
