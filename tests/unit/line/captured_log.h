#pragma once
// The program's log as text, while this lives. Made before the threads that log, destroyed after
// them.

#include <spdlog/details/null_mutex.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <mutex>
#include <string>

namespace driftwise::tests {

class CapturedLog {
 public:
  CapturedLog() : before_(spdlog::default_logger()) {
    auto logger = std::make_shared<spdlog::logger>("captured", std::make_shared<Sink>(*this));
    logger->set_pattern("%l: %v");
    spdlog::set_default_logger(std::move(logger));
  }
  ~CapturedLog() { spdlog::set_default_logger(before_); }
  CapturedLog(const CapturedLog&) = delete;
  CapturedLog& operator=(const CapturedLog&) = delete;

  std::string text() const {
    const std::lock_guard lock(mutex_);
    return text_;
  }

 private:
  class Sink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
   public:
    explicit Sink(CapturedLog& log) : log_(log) {}

   private:
    void sink_it_(const spdlog::details::log_msg& message) override {
      spdlog::memory_buf_t line;
      const std::lock_guard lock(log_.mutex_);
      formatter_->format(message, line);
      log_.text_.append(line.data(), line.size());
    }
    void flush_() override {}
    CapturedLog& log_;
  };

  std::shared_ptr<spdlog::logger> before_;
  mutable std::mutex mutex_;
  std::string text_;
};

}  // namespace driftwise::tests
