#pragma once
// The part of SCPI (IEEE 488.2, SCPI-99 volume 1) that a multimeter needs: messages made of units
// joined by ';', headers in long and short form, case-blind, with optional nodes, a path that the
// next unit of a message starts from, and arguments. Common commands ("*RST") stand outside the
// path. No device knowledge here.

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace driftwise::simulated {

// Standard error numbers and texts, plus the device's own positive ones.
std::string scpi_error_text(int code);

// First in, first out; when full the newest place turns into -350 and further errors are lost.
class ScpiErrorQueue {
 public:
  explicit ScpiErrorQueue(std::size_t depth = 10) : depth_(depth) {}
  void push(int code);
  std::string pop();  // -113,"Undefined header"; empty: 0,"No error"
  bool empty() const { return codes_.empty(); }
  void clear() { codes_.clear(); }

 private:
  std::size_t depth_;
  std::deque<int> codes_;
};

struct ScpiUnit {
  std::vector<std::string>
      nodes;              // upper case: {"FRES", "NPLC"}; a common command is one node "*RST"
  bool absolute = false;  // began with ':'
  bool common = false;
  bool query = false;
  std::vector<std::string> arguments;
};

// A unit, or the error number: -101 invalid character, -102 syntax, -112 mnemonic too long.
struct ScpiParse {
  std::optional<ScpiUnit> unit;  // none with error 0: an empty unit
  int error = 0;
};
std::vector<std::string> split_units(std::string_view message);  // at ';' outside quotes
ScpiParse parse_unit(std::string_view text);

// What a handler answers. wait: the reply comes later, the message stops here until then.
struct ScpiAnswer {
  int error = 0;
  std::optional<std::string> text;
  double busy_s = 0;  // the device does nothing else for so long
  bool wait = false;
};
inline ScpiAnswer scpi_error(int code) { return {.error = code, .text = {}}; }
inline ScpiAnswer scpi_text(std::string text) { return {.text = std::move(text)}; }
inline ScpiAnswer scpi_done() { return {}; }
inline ScpiAnswer scpi_bool(bool on) { return scpi_text(on ? "1" : "0"); }

class ScpiTree {
 public:
  using Arguments = std::vector<std::string>;
  using Handler = std::function<ScpiAnswer(const Arguments&)>;

  // "[SENSe]:FRESistance:NPLCycles": capitals are the short form, brackets mark an optional node. A
  // node may carry the suffix 1 on the wire. A missing handler: that form does not exist (-113).
  void add(std::string_view pattern, Handler command, Handler query);
  // Follows and moves the path. -113 when nothing matches.
  ScpiAnswer call(const ScpiUnit& unit, std::vector<std::string>& path) const;

 private:
  struct Node {
    std::string long_form, short_form;
    bool optional;
  };
  struct Entry {
    std::vector<Node> nodes;
    Handler command, query;
  };
  static bool matches(const std::vector<Node>& pattern, std::size_t p,
                      const std::vector<std::string>& nodes, std::size_t n);
  std::vector<Entry> entries_;
};

}  // namespace driftwise::simulated
