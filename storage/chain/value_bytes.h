#pragma once
// Values as the chain's bytes: one way to write each, so that two values have the same bytes only
// when they are the same. docs/database.md, "The chain", has the format for checkers of others.
//   NULL     0x10
//   INTEGER  0x00..0x08: how many bytes follow; two's complement, big-endian, as few as hold it
//   REAL     0x11, 8 bytes: IEEE 754, big-endian
//   TEXT     0x12, INTEGER length, its bytes
//   BLOB     0x13, INTEGER length, its bytes

#include <sqlite3.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace driftwise::storage {

void add_integer(std::string& bytes, std::int64_t value);
void add_text(std::string& bytes, std::string_view value);
void add_blob(std::string& bytes, std::string_view value);
void add_value(std::string& bytes, sqlite3_value* value);
void add_column(std::string& bytes, sqlite3_stmt* row, int column);

// Reads what stands in a BLOB of the chain. A text that is too short or has another form makes
// good() false; what is read from then on is empty.
class BytesReader {
 public:
  explicit BytesReader(std::string_view bytes) : all_(bytes) {}
  bool good() const { return good_; }
  bool at_end() const { return at_ == all_.size(); }
  std::size_t at() const { return at_; }
  void go_to(std::size_t place);

  std::int64_t integer();
  std::string_view fixed(std::size_t length);
  // The bytes of one value of any type, as they stand.
  std::string_view value();

 private:
  std::string_view all_;
  std::size_t at_ = 0;
  bool good_ = true;
};

// One value as a person reads it: 812, 0.5, 'laser-x', NULL.
std::string value_text(std::string_view value);

}  // namespace driftwise::storage
