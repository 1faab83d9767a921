#pragma once
// Words and numbers set one after another at the end of a string. They are written into a buffer of
// their own, which joins the string when it is full and at the end: one copy, no allocation where
// the string has the room.

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace driftwise::formats {

class TextWriter {
 public:
  explicit TextWriter(std::string& out) : out_(out) {}
  TextWriter(const TextWriter&) = delete;
  TextWriter& operator=(const TextWriter&) = delete;
  ~TextWriter() { flush(); }

  template <std::size_t size>
  TextWriter& operator<<(const char (&literal)[size]) {
    static_assert(size <= kRoom);
    make_room(size);
    std::memcpy(at_, literal, size);  // with its 0, which the next one overwrites
    at_ += size - 1;
    return *this;
  }
  TextWriter& operator<<(std::string_view text) {
    if (text.size() > kRoom) return append(text);
    make_room(text.size());
    std::memcpy(at_, text.data(), text.size());
    at_ += text.size();
    return *this;
  }
  // Shortest digits that read back as the same double; nothing for NaN and the infinities.
  TextWriter& operator<<(double value);
  TextWriter& operator<<(std::int64_t value);
  // As std::to_chars(fixed) does it: the exact value rounded, half to even. decimals: 1 to 4.
  TextWriter& fixed(double value, int decimals);

  // The string holds the text afterwards.
  void flush() {
    out_.append(buffer_.data(), at_);
    at_ = buffer_.data();
  }

 private:
  static constexpr std::size_t kRoom = 1024;
  void make_room(std::size_t size) {
    if (static_cast<std::size_t>(buffer_.data() + kRoom - at_) < size) flush();
  }
  TextWriter& append(std::string_view text) {
    flush();
    out_ += text;
    return *this;
  }

  std::string& out_;
  std::array<char, kRoom> buffer_;
  char* at_ = buffer_.data();
};

}  // namespace driftwise::formats
