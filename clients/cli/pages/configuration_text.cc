#include "clients/cli/pages/configuration_text.h"

#include "clients/cli/core/text.h"

namespace driftwise::cli {
namespace {

std::string whole_nm_text(double nm) { return fixed(nm, nm < 99.95 ? 1 : 0) + " nm"; }

}  // namespace

std::string change_text(const v1::ConfigurationChange& change) {
  const auto shown = [](const std::string& value) { return value.empty() ? "not given" : value; };
  if (change.key().empty() && change.before().empty())
    return change.place() + ": new: " + change.after();
  if (change.key().empty() && change.after().empty())
    return change.place() + ": gone: " + change.before();
  return change.place() + ": " + (change.key().empty() ? "" : change.key() + " ") +
         shown(change.before()) + " -> " + shown(change.after());
}

std::string length_text(const v1::LengthChange& change) {
  return change.channel() + " of run " + std::to_string(change.run_id()) +
         (change.run_name().empty() ? "" : " '" + change.run_name() + "'") + " by up to " +
         whole_nm_text(change.largest_nm()) + " (rms " + whole_nm_text(change.rms_nm()) + ") in " +
         std::to_string(change.row_count()) + " rows";
}

std::vector<std::string> mark_texts(const v1::CorrectionMark& mark) {
  std::vector<std::string> lines;
  lines.push_back(
      "correction " + std::to_string(mark.correction_id()) +
      (mark.has_diagnosis_id() ? " of diagnosis " + std::to_string(mark.diagnosis_id()) : "") +
      (mark.has_end_time()
           ? ", taken back " + clock_text(mark.end_time()) + " UTC by " + mark.ended_by()
           : ", in force since " + clock_text(mark.accept_time()) + " UTC by " +
                 mark.accepted_by()));
  for (const auto& change : mark.changes()) lines.push_back("  changes " + length_text(change));
  return lines;
}

}  // namespace driftwise::cli
