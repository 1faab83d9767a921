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

TruthLog::TruthLog(const std::filesystem::path& file, std::span<const std::string> node_names) {
  std::error_code ignored;
  const auto size = std::filesystem::file_size(file, ignored);
  const bool is_new = ignored || size == 0;
  out_.open(file, std::ios::app);
  if (!out_) {
    throw std::runtime_error("truth log: cannot write '" + file.string() +
                             "': give a folder that exists and can be written to");
  }
  if (!is_new) return;
  out_ << "time_ns,kind,commanded_nm,q_scale_nm,end_effector_nm,interferometer_true_nm,"
          "robot_drift_nm,device_drift_nm,air_error_nm,geometry_nm,air_degC,room_degC,pressure_hPa";
  for (const auto& name : node_names) out_ << ',' << name << "_degC";
  out_ << '\n' << std::flush;
}

void TruthLog::append(std::string_view kind, const Truth& truth) {
  std::string line = std::to_string(truth.time);
  line += ',';
  line += kind;
  for (const double value :
       {truth.commanded_nm, truth.q_scale_nm, truth.end_effector_nm, truth.interferometer_true_nm,
        truth.robot_drift_nm, truth.device_drift_nm, truth.air_error_nm, truth.geometry_nm,
        truth.air_degc, truth.room_degc, truth.pressure_hpa}) {
    put(line, value);
  }
  for (const double value : truth.node_degc) put(line, value);
  line += '\n';
  out_ << line << std::flush;
}

}  // namespace driftwise::simulated
