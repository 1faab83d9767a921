#include "clients/cli/pages/join_page.h"

#include <string>

#include "clients/cli/core/table.h"
#include "server/core/text/quantity_text.h"

namespace driftwise::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string figure(const Json& json, const std::string& key, const std::string& unit) {
  const auto found = json.find(key + "_" + unit);
  return found == json.end() ? "" : digits_text(found->get<double>());
}

std::string sources_text(const Json& channel) {
  std::string text;
  for (const auto& source : channel.at("sources"))
    text += (text.empty() ? "" : ", ") + source.get<std::string>();
  return text;
}

}  // namespace

void print_join(std::ostream& out, const Paint& paint, const Json& report) {
  out << report.at("rows") << " rows joined";
  if (const auto unmatched = report.at("unmatched_rows").get<int>(); unmatched > 0)
    out << ", " << unmatched << " left out";
  out << '\n';
  for (const auto& part : report.at("parts"))
    out << "  " << part.at("name").get<std::string>() << ": " << part.at("rows") << " rows, sha256 "
        << part.at("hash").get<std::string>().substr(0, 12) << '\n';
  if (report.contains("temperature_difference_k"))
    out << "  temperatures of the datums: at most "
        << digits_text(report.at("temperature_difference_k").get<double>()) << " K apart ("
        << report.at("temperature_channel").get<std::string>() << ")\n";
  if (report.contains("zero_difference_nm"))
    out << "  motor coordinates at pose zero: at most "
        << digits_text(report.at("zero_difference_nm").get<double>()) << " nm apart\n";
  out << '\n';
  Table table({{"channel", Align::left},
               {"from", Align::left},
               {"u", Align::right},
               {"unit", Align::left},
               {"median of difference", Align::right},
               {"sigma", Align::right},
               {"largest", Align::right},
               {"in row", Align::right}});
  for (const auto& channel : report.at("channels")) {
    const auto unit = channel.at("unit").get<std::string>();
    const Json check = channel.value("check", Json::object());
    if (check.empty() && !channel.contains("u_" + unit)) continue;
    table.add({channel.at("channel").get<std::string>(), sources_text(channel),
               figure(channel, "u", unit), unit, figure(check, "median", unit),
               figure(check, "sigma", unit), figure(check, "largest", unit),
               check.empty() ? "" : std::to_string(check.at("largest_row").get<int>())});
  }
  table.print(out, paint);
  for (const auto& warning : report.at("warnings"))
    out << paint.warn("warning") << ": " << warning.get<std::string>() << '\n';
}

}  // namespace driftwise::cli
