#pragma once
// What `driftwise watch` shows: the cell as the stream tells it, and a screen of text drawn from
// that. Pure: no clock, no terminal.

#include <map>
#include <set>
#include <string>
#include <vector>

#include "clients/cli/core/console.h"
#include "driftwise/v1/watch_service.pb.h"

namespace driftwise::cli {

class LivePicture {
 public:
  // only: channels to show, without their unit or with it ("x", "t07_degC"); empty: all.
  explicit LivePicture(std::set<std::string> only) : only_(std::move(only)) {}

  void take(const v1::WatchResponse& batch);
  void take(const v1::GetSeriesResponse& history);  // for the sparklines
  // Channels shown, in order of the layout: what history to ask for.
  std::vector<std::string> channels() const;
  // The words of --channels that name none; only once the layout is known.
  std::vector<std::string> unknown() const;

  // Lines of at most width characters, at most height of them; what does not fit is counted in the
  // last one. No line end after the last one: a full window would scroll its first line away.
  // trouble: why nothing comes any more; empty: it is live.
  std::string screen(const Paint& paint, std::size_t width, std::size_t height,
                     const std::string& trouble) const;
  // One line, for a log.
  std::string line() const;

 private:
  bool shown(const v1::ChannelLayout::Column& column) const;
  std::vector<std::string> head(const Paint& paint, std::size_t width,
                                const std::string& trouble) const;
  std::vector<std::string> values(const Paint& paint, std::size_t width) const;

  std::set<std::string> only_;
  v1::ChannelLayout layout_;
  v1::ValuesUpdate values_;
  v1::GetStatusResponse cell_;
  v1::RunProgress progress_;
  bool run_known_ = false;
  std::map<std::string, v1::Alarm> alarms_;  // by what they are of: not all have a number yet
  std::map<std::string, std::vector<double>> history_;
  google::protobuf::Timestamp cell_time_;
};

}  // namespace driftwise::cli
