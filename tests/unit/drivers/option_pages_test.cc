// Options of the drivers, as their sources ask for them: each is in a page of docs.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = DRIFTWISE_SOURCE_DIR;

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::set<std::string> options_of_drivers() {
  const std::regex asked(
      R"re((?:reader|options)\.(?:text|choice|on_off|number|integer)\(\s*"([a-z0-9_]+)")re");
  const std::regex declared(R"re(declared\("([a-z0-9_]+)", out\.)re");  // of a controller's loop
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "drivers")) {
    const auto& path = entry.path();
    if (path.extension() != ".cc" || path.string().find("/simulated/") != std::string::npos)
      continue;
    const std::string text = text_of(path);
    if (text.find("OptionReader") == std::string::npos) continue;
    for (const auto& pattern : {asked, declared})
      for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at)
        names.insert((*at)[1]);
  }
  return names;
}

TEST(OptionPages, HaveEveryOptionThatADriverTakes) {
  std::string pages;
  for (const auto& entry : fs::directory_iterator(kRoot / "docs" / "devices"))
    pages += text_of(entry.path());
  const auto options = options_of_drivers();
  for (const char* known : {"dead_path_mm", "home_stall_s", "baud", "heat_band_k", "ups"})
    EXPECT_TRUE(options.contains(known)) << "the pattern does not see " << known;
  for (const auto& option : options)
    EXPECT_NE(pages.find("`" + option + "`"), std::string::npos)
        << option << ": add a row to a page in docs/devices: name, unit, default, what it does";
}

}  // namespace
