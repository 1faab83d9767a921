#include "storage/datasets/dataset_columns.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <tuple>

namespace driftwise::storage {
namespace {

constexpr std::array<std::string_view, 6> kPose = {"x", "y", "z", "rx", "ry", "rz"};

int number_in(std::string_view text) {
  int number = 0;
  const std::size_t first = text.find_first_of("0123456789");
  if (first != std::string_view::npos)
    std::from_chars(text.data() + first, text.data() + text.size(), number);
  return number;
}

int pose_index(std::string_view symbol) {
  return static_cast<int>(std::ranges::find(kPose, symbol) - kPose.begin());
}

// The study's habit: t01_degC, t02_degC, ... stand together by number.
bool is_numbered_thermometer(const Channel& channel) {
  const std::string_view symbol = channel.symbol;
  return channel.unit == "degC" && symbol.size() > 1 && symbol.front() == 't' &&
         symbol.find_first_not_of("0123456789", 1) == std::string_view::npos;
}

std::tuple<int, int> rank(const Channel& channel) {
  const std::string_view symbol = channel.symbol;
  const auto stem = [&](std::string_view suffix) {
    return symbol.ends_with(suffix) ? symbol.substr(0, symbol.size() - suffix.size())
                                    : std::string_view();
  };
  if (is_motor_symbol(symbol)) return {0, number_in(symbol)};
  if (is_motor_symbol(stem("_cmd"))) return {1, number_in(symbol)};
  if (is_pose_symbol(symbol)) return {2, pose_index(symbol)};
  if (is_pose_symbol(stem("_std"))) return {3, pose_index(stem("_std"))};
  if (is_numbered_thermometer(channel)) return {4, number_in(symbol)};
  return {5, 0};
}

}  // namespace

void sort_as_dataset(std::vector<Channel>& channels) {
  std::ranges::stable_sort(channels, {}, rank);
}

}  // namespace driftwise::storage
