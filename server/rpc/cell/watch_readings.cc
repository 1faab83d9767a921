#include <deque>

#include "server/application/watching/feeds.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using application::Feeds;

constexpr std::size_t kMostWaiting = 256;

class ReadingSource final : public StreamSource<v1::WatchReadingsResponse> {
 public:
  ReadingSource(Feeds& feeds, std::string device) : feeds_(feeds), device_(std::move(device)) {}

  void start(std::function<void()> wake) override {
    watch_ = feeds_.watch_readings([this, wake = std::move(wake)](const Reading& reading) {
      if (!device_.empty() && reading.device != device_) return;
      if (waiting_.size() == kMostWaiting) {  // the oldest goes: the client is behind already
        waiting_.pop_front();
        ++missed_;
      }
      waiting_.push_back(reading);
      wake();
    });
  }

  std::optional<v1::WatchReadingsResponse> next() override {
    if (waiting_.empty()) return std::nullopt;
    v1::WatchReadingsResponse response;
    *response.mutable_reading() = reading_from(waiting_.front());
    response.set_missed_count(missed_);
    waiting_.pop_front();
    missed_ = 0;
    return response;
  }
  std::optional<Result<void>> ended() override { return std::nullopt; }

 private:
  Feeds& feeds_;
  std::string device_;
  std::deque<Reading> waiting_;
  std::int64_t missed_ = 0;
  std::shared_ptr<void> watch_;  // last: it goes first, and with it the callback that knows this
};

}  // namespace

std::unique_ptr<StreamSource<v1::WatchReadingsResponse>> watch_readings(Feeds& feeds,
                                                                        std::string device) {
  return std::make_unique<ReadingSource>(feeds, std::move(device));
}

}  // namespace driftwise::rpc
