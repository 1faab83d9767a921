// ROUTe: which channels a scan visits, and the relay of a single channel.

#include <algorithm>

#include "drivers/simulated/emulators/keithley_2701/keithley_emulator.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {

void KeithleyEmulator::add_route_commands() {
  const auto idle = [this] { return !run_.has_value(); };
  tree_.add(
      "ROUTe:SCAN[:INTernal]",
      [this, idle](const Arguments& arguments) {
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const auto list = parse_channel_list(arguments[0], cards_);
        if (list.error != 0) return scpi_error(list.error);
        if (list.channels.empty()) return scpi_error(-109);
        if (!idle()) return scpi_error(-221);
        scan_list_ = list.channels;
        if (!typed_order_) std::sort(scan_list_.begin(), scan_list_.end());
        std::vector<int> once;
        for (const int channel : scan_list_)
          if (std::find(once.begin(), once.end(), channel) == once.end()) once.push_back(channel);
        scan_list_ = std::move(once);
        shrink_scan();
        return scpi_done();
      },
      [this](const Arguments&) { return scpi_text(channel_list_text(scan_list_)); });
  tree_.add(
      "ROUTe:SCAN:LSELect",
      [this, idle](const Arguments& arguments) {
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const std::string word = upper(arguments[0]);
        const bool on = word == "INT" || word == "INTERNAL";
        if (!on && word != "NONE") return scpi_error(-224);
        if (!idle()) return scpi_error(-221);
        scanning_ = on;
        if (on) closed_.reset();
        return scpi_done();
      },
      [this](const Arguments&) { return scpi_text(scanning_ ? "INT" : "NONE"); });
  tree_.add(
      "ROUTe:SCAN:TSOurce",
      [](const Arguments& arguments) {
        if (arguments.empty()) return scpi_error(-109);
        const std::string word = upper(arguments[0]);
        // Limits that could start a scan are not modelled: only IMMediate is taken.
        return word == "IMM" || word == "IMMEDIATE" ? scpi_done() : scpi_error(-224);
      },
      [](const Arguments&) { return scpi_text("IMM"); });
  tree_.add(
      "ROUTe:CLOSe",
      [this](const Arguments& arguments) {
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const auto list = parse_channel_list(arguments[0], cards_);
        if (list.error != 0) return scpi_error(list.error);
        if (list.channels.size() != 1) return scpi_error(-223);
        if (scanning_) return scpi_error(-221);
        closed_ = list.channels.front();
        return scpi_done();
      },
      [this](const Arguments&) {
        return scpi_text(closed_ ? channel_list_text({*closed_}) : std::string("(@)"));
      });
  tree_.add(
      "ROUTe:OPEN:ALL",
      [this](const Arguments& arguments) {
        if (!arguments.empty()) return scpi_error(-108);
        closed_.reset();
        return scpi_done();
      },
      nullptr);
}

}  // namespace driftwise::simulated
