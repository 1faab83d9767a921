#include "server/clean_log.h"

#include <spdlog/formatter.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <cstddef>
#include <memory>

#include "server/core/text/clean_text.h"

namespace driftwise {
namespace {

class CleanLines final : public spdlog::formatter {
 public:
  explicit CleanLines(std::unique_ptr<spdlog::formatter> inner) : inner_(std::move(inner)) {}

  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    const std::string text = clean_line({message.payload.data(), message.payload.size()});
    spdlog::details::log_msg cleaned = message;
    cleaned.payload = text;
    inner_->format(cleaned, out);
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<CleanLines>(inner_->clone());
  }

 private:
  std::unique_ptr<spdlog::formatter> inner_;
};

constexpr std::size_t kKeptLines = 4000;
std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> kept_lines;

}  // namespace

void set_up_log(const std::string& level) {
  kept_lines = std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(kKeptLines);
  const spdlog::sinks_init_list sinks{std::make_shared<spdlog::sinks::stderr_sink_mt>(),
                                      kept_lines};
  auto logger = std::make_shared<spdlog::logger>("driftwised", sinks);
  logger->set_level(spdlog::level::from_str(level));
  logger->set_formatter(std::make_unique<CleanLines>(std::make_unique<spdlog::pattern_formatter>(
      "%Y-%m-%dT%H:%M:%S.%eZ %^%l%$ %v", spdlog::pattern_time_type::utc)));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(logger);
}

std::vector<std::string> log_tail() {
  return kept_lines ? kept_lines->last_formatted() : std::vector<std::string>();
}

}  // namespace driftwise
