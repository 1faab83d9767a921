#include "drivers/simulated/plant/truth_log.h"

#include <array>
#include <charconv>
#include <stdexcept>

namespace driftwise::simulated {
namespace {

void put(std::string& line, double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  line += ',';
  line.append(text.data(), end);
}

}  // namespace

TruthLog::TruthLog(const std::filesystem::path& file, std::span<const std::string> columns) {
  std::error_code ignored;
  const auto size = std::filesystem::file_size(file, ignored);
  const bool is_new = ignored || size == 0;
  out_.open(file, std::ios::app);
  if (!out_) {
    throw std::runtime_error("truth log: cannot write '" + file.string() +
                             "': give a folder that exists and can be written to");
  }
  if (!is_new) return;
  out_ << "time_ns,kind";
  for (const auto& name : columns) out_ << ',' << name;
  out_ << '\n' << std::flush;
}

void TruthLog::append(std::string_view kind, TimeNs time, std::span<const double> values) {
  std::string line = std::to_string(time);
  line += ',';
  line += kind;
  for (const double value : values) put(line, value);
  line += '\n';
  out_ << line << std::flush;
}

}  // namespace driftwise::simulated
