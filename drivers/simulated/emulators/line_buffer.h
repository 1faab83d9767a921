#pragma once
// Cuts a stream of bytes into lines. Bounded: of a line longer than the limit the head is kept and
// the rest dropped, and the line is marked.

#include <optional>
#include <string>

namespace driftwise::simulated {

class LineBuffer {
 public:
  struct Line {
    std::string text;  // without the terminator
    bool overrun = false;
  };

  explicit LineBuffer(char terminator = '\n', std::size_t limit = 4096)
      : terminator_(terminator), limit_(limit) {}

  // The finished line when this byte ends one.
  std::optional<Line> push(char byte) {
    if (byte == terminator_) {
      Line done{std::move(text_), overrun_};
      clear();
      return done;
    }
    if (text_.size() < limit_)
      text_ += byte;
    else
      overrun_ = true;
    return std::nullopt;
  }
  const std::string& unfinished() const { return text_; }
  void clear() {
    text_.clear();
    overrun_ = false;
  }

 private:
  char terminator_;
  std::size_t limit_;
  std::string text_;
  bool overrun_ = false;
};

}  // namespace driftwise::simulated
