#include "clients/cli/pages/live_picture.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/pages/progress_bar.h"
#include "clients/cli/pages/run_text.h"
#include "clients/cli/pages/sparkline.h"

namespace driftwise::cli {
namespace {

constexpr std::size_t kSparkWidth = 40;

// "t07_degC" -> "t07"
std::string symbol_of(const v1::ChannelLayout::Column& column) {
  const std::string ending = "_" + column.unit();
  return column.channel().ends_with(ending)
             ? column.channel().substr(0, column.channel().size() - ending.size())
             : column.channel();
}

std::string value_text(const v1::ChannelLayout::Column& column, double value) {
  const int decimals = column.unit() == "mm" ? 6 : column.unit() == "nm" ? 1 : 4;
  return std::isfinite(value) ? fixed(value, decimals) : "-";
}

// What goes with Paint may be longer than it looks: only plain text is cut.
std::string cut(const std::string& text, std::size_t width) {
  if (width_of(text) <= width) return text;
  std::string out;
  for (std::size_t i = 0, shown = 0; i < text.size() && shown + 1 < width; ++shown) {
    std::size_t next = i + 1;
    while (next < text.size() && (static_cast<unsigned char>(text[next]) & 0xC0) == 0x80) ++next;
    out += text.substr(i, next - i);
    i = next;
  }
  return out + "…";
}

// Numbers come with the record, which may take nothing for a while.
std::string occurrence_of(const v1::Alarm& alarm) {
  return alarm.kind() + "\n" + alarm.subject() + "\n" +
         std::to_string(alarm.since_time().seconds()) + "." +
         std::to_string(alarm.since_time().nanos());
}

}  // namespace

void LivePicture::take(const v1::WatchResponse& batch) {
  if (batch.has_cell_time()) cell_time_ = batch.cell_time();
  for (const auto& event : batch.events()) {
    if (event.has_layout()) layout_ = event.layout();
    if (event.has_values()) values_ = event.values();
    if (event.has_cell()) cell_ = event.cell();
    if (event.has_progress()) progress_ = event.progress(), run_known_ = true;
    if (event.has_alarm()) {
      const auto& alarm = event.alarm();
      if (alarm.has_cleared_time())
        alarms_.erase(occurrence_of(alarm));
      else
        alarms_[occurrence_of(alarm)] = alarm;
    }
  }
}

void LivePicture::take(const v1::GetSeriesResponse& history) {
  for (const auto& series : history.series()) {
    auto& values = history_[series.channel()];
    values.clear();
    for (const float mean : series.mean()) values.push_back(series.base() + mean);
  }
}

bool LivePicture::shown(const v1::ChannelLayout::Column& column) const {
  return only_.empty() || only_.contains(column.channel()) || only_.contains(symbol_of(column));
}

std::vector<std::string> LivePicture::channels() const {
  std::vector<std::string> names;
  for (const auto& column : layout_.columns())
    if (shown(column)) names.push_back(column.channel());
  return names;
}

std::vector<std::string> LivePicture::unknown() const {
  std::vector<std::string> words;
  if (layout_.columns_size() == 0) return words;
  for (const auto& word : only_)
    if (std::none_of(layout_.columns().begin(), layout_.columns().end(), [&](const auto& column) {
          return word == column.channel() || word == symbol_of(column);
        }))
      words.push_back(word);
  return words;
}

std::vector<std::string> LivePicture::head(const Paint& paint, std::size_t width,
                                           const std::string& trouble) const {
  std::vector<std::string> lines;
  const std::string clock = utc_text(cell_time_);
  const std::string name = paint.bold(cut(cell_.cell_name(), width / 3)) + "  ";
  lines.push_back(trouble.empty() ? name + paint.good("● live") + "  " + clock
                                  : name + paint.bad("■ not live") + " since " + clock);
  if (!trouble.empty()) lines.push_back(cut(trouble, width));
  if (run_known_ && !is_over(progress_.run().state()))
    lines.push_back(progress_line(progress_, std::nan(""), static_cast<int>(width)));
  else
    lines.push_back("no run under way");
  std::vector<std::string> sentences(cell_.attention().begin(), cell_.attention().end());
  for (const auto& [occurrence, alarm] : alarms_)
    if (std::find(sentences.begin(), sentences.end(), alarm.message()) == sentences.end())
      sentences.push_back(alarm.message());
  for (const auto& sentence : sentences)
    lines.push_back(paint.warn("▲ ") + cut(sentence, width - 2));
  return lines;
}

std::vector<std::string> LivePicture::values(const Paint& paint, std::size_t width) const {
  const bool with_history = width >= 60;
  std::vector<Table::Column> columns{
      {"channel"}, {"value", Align::right}, {"unit"}, {"age", Align::right}, {""}};
  if (with_history) columns.push_back({"last 10 min"});
  Table table(columns);
  for (int i = 0; i < layout_.columns_size(); ++i) {
    const auto& column = layout_.columns(i);
    if (!shown(column)) continue;
    const bool known = i < values_.values_size() && values_.layout_revision() == layout_.revision();
    const double age_s =
        known && i < values_.age_ms_size() ? static_cast<double>(values_.age_ms(i)) / 1e3 : -1;
    const bool stale = age_s < 0 || (column.stale_after_s() > 0 && age_s > column.stale_after_s());
    std::vector<Table::Cell> row{symbol_of(column),
                                 known ? value_text(column, values_.values(i)) : "-", column.unit(),
                                 age_s < 0 ? "never" : span_text(age_s), stale ? "stale" : ""};
    if (with_history) {
      const auto past = history_.find(column.channel());
      row.push_back(
          past == history_.end() ? "" : sparkline(past->second, std::min(kSparkWidth, width - 50)));
    }
    table.add(std::move(row));
  }
  std::ostringstream text;
  table.print(text, paint);
  std::vector<std::string> lines;
  std::istringstream parts(text.str());
  for (std::string line; std::getline(parts, line);) lines.push_back(line);
  return lines;
}

std::string LivePicture::screen(const Paint& paint, std::size_t width, std::size_t height,
                                const std::string& trouble) const {
  std::vector<std::string> lines = head(paint, width, trouble);
  lines.emplace_back();
  for (auto& line : values(paint, width)) lines.push_back(std::move(line));
  if (lines.size() > height && height > 0) {
    const std::size_t left_out = lines.size() - height + 1;
    lines.resize(height - 1);
    lines.push_back(paint.dim("... " + std::to_string(left_out) +
                              " more lines; a larger window or --channels shows them"));
  }
  std::string text;
  for (const auto& line : lines) text += (text.empty() ? "" : "\n") + line;
  return text;
}

std::string LivePicture::line() const {
  std::string text = utc_text(cell_time_) + "  ";
  text += run_known_ && !is_over(progress_.run().state())
              ? progress_line(progress_, std::nan(""), 120)
              : "no run under way";
  if (!only_.empty())
    for (int i = 0; i < layout_.columns_size() && i < values_.values_size(); ++i)
      if (shown(layout_.columns(i)))
        text += "  " + layout_.columns(i).channel() + "=" +
                value_text(layout_.columns(i), values_.values(i));
  for (const auto& sentence : cell_.attention()) text += "  ! " + sentence;
  return text;
}

}  // namespace driftwise::cli
