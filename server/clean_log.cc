#include "server/clean_log.h"

#include <spdlog/pattern_formatter.h>

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

}  // namespace

std::unique_ptr<spdlog::formatter> clean_log_formatter(const std::string& pattern) {
  return std::make_unique<CleanLines>(
      std::make_unique<spdlog::pattern_formatter>(pattern, spdlog::pattern_time_type::utc));
}

}  // namespace driftwise
