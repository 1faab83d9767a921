#include "clients/cli/session.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>

namespace driftwise::cli {

std::string read_input_file(const std::string& path) {
  if (path == "-") return {std::istreambuf_iterator<char>(std::cin), {}};
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw Failure{ExitCode::bad_input, "invalid_argument", "NOT_A_FILE",
                  path + " is a folder, expected a file"};
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Failure{ExitCode::bad_input, "not_found", "NO_FILE",
                  "cannot read " + path + ": " + std::strerror(errno)};
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string base_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

void write_output_file(const std::string& path, const std::string& text) {
  const std::string temporary = path + ".part";
  const auto fail = [&](const std::string& file) {
    throw Failure{ExitCode::bad_input, "invalid_argument", "CANNOT_WRITE",
                  "cannot write " + file + ": " + std::strerror(errno)};
  };
  {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    if (!file || !(file << text).flush()) fail(temporary);
  }
  if (std::rename(temporary.c_str(), path.c_str()) != 0) fail(path);
}

}  // namespace driftwise::cli
