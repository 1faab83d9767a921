#include "storage/chain/value_bytes.h"

#include <bit>
#include <charconv>

namespace driftwise::storage {
namespace {

constexpr char kMostIntegerBytes = 8, kNull = 0x10, kReal = 0x11, kText = 0x12, kBlob = 0x13;

void add_big_endian(std::string& bytes, std::uint64_t value, int count) {
  char all[8];
  for (int i = 0; i < count; ++i)
    all[i] = static_cast<char>(static_cast<unsigned char>(value >> (8 * (count - 1 - i))));
  bytes.append(all, static_cast<std::size_t>(count));
}

std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char c : bytes) value = (value << 8) | static_cast<unsigned char>(c);
  return value;
}

// 0 for 0: no byte at all.
int integer_bytes(std::int64_t value) {
  if (value == 0) return 0;
  for (int count = 1; count < 8; ++count) {
    const std::int64_t limit = std::int64_t{1} << (8 * count - 1);
    if (value >= -limit && value < limit) return count;
  }
  return 8;
}

std::int64_t integer_from(std::string_view bytes) {
  if (bytes.empty()) return 0;
  const bool negative = (static_cast<unsigned char>(bytes.front()) & 0x80) != 0;
  std::uint64_t value = negative ? ~std::uint64_t{0} : 0;
  for (const char c : bytes) value = (value << 8) | static_cast<unsigned char>(c);
  return static_cast<std::int64_t>(value);
}

void add_real(std::string& bytes, double value) {
  bytes += kReal;
  add_big_endian(bytes, std::bit_cast<std::uint64_t>(value), 8);
}

}  // namespace

void add_integer(std::string& bytes, std::int64_t value) {
  const int count = integer_bytes(value);
  bytes += static_cast<char>(count);
  add_big_endian(bytes, static_cast<std::uint64_t>(value), count);
}

void add_text(std::string& bytes, std::string_view value) {
  bytes += kText;
  add_integer(bytes, static_cast<std::int64_t>(value.size()));
  bytes += value;
}

void add_blob(std::string& bytes, std::string_view value) {
  bytes += kBlob;
  add_integer(bytes, static_cast<std::int64_t>(value.size()));
  bytes += value;
}

void add_value(std::string& bytes, sqlite3_value* value) {
  const auto content = [value](const void* data) {
    return std::string_view(static_cast<const char*>(data),
                            static_cast<std::size_t>(sqlite3_value_bytes(value)));
  };
  switch (sqlite3_value_type(value)) {
    case SQLITE_INTEGER:
      return add_integer(bytes, sqlite3_value_int64(value));
    case SQLITE_FLOAT:
      return add_real(bytes, sqlite3_value_double(value));
    case SQLITE_TEXT:
      return add_text(bytes, content(sqlite3_value_text(value)));
    case SQLITE_BLOB:
      return add_blob(bytes, content(sqlite3_value_blob(value)));
    default:
      bytes += kNull;
  }
}

void add_column(std::string& bytes, sqlite3_stmt* row, int column) {
  const auto content = [row, column](const void* data) {
    return std::string_view(static_cast<const char*>(data),
                            static_cast<std::size_t>(sqlite3_column_bytes(row, column)));
  };
  switch (sqlite3_column_type(row, column)) {
    case SQLITE_INTEGER:
      return add_integer(bytes, sqlite3_column_int64(row, column));
    case SQLITE_FLOAT:
      return add_real(bytes, sqlite3_column_double(row, column));
    case SQLITE_TEXT:
      return add_text(bytes, content(sqlite3_column_text(row, column)));
    case SQLITE_BLOB:
      return add_blob(bytes, content(sqlite3_column_blob(row, column)));
    default:
      bytes += kNull;
  }
}

void BytesReader::go_to(std::size_t place) {
  good_ = place <= all_.size();
  at_ = good_ ? place : all_.size();
}

std::string_view BytesReader::fixed(std::size_t length) {
  if (!good_ || length > all_.size() - at_) {
    good_ = false;
    at_ = all_.size();
    return {};
  }
  const auto bytes = all_.substr(at_, length);
  at_ += length;
  return bytes;
}

std::int64_t BytesReader::integer() {
  const auto head = fixed(1);
  if (head.empty() || head.front() < 0 || head.front() > kMostIntegerBytes) {
    good_ = false;
    return 0;
  }
  return integer_from(fixed(static_cast<std::size_t>(head.front())));
}

std::string_view BytesReader::value() {
  const std::size_t begin = at_;
  const auto head = fixed(1);
  if (head.empty()) return {};
  if (head.front() == kReal) {
    fixed(8);
  } else if (head.front() == kText || head.front() == kBlob) {
    const std::int64_t length = integer();
    if (length < 0) good_ = false;
    if (good_) fixed(static_cast<std::size_t>(length));
  } else if (head.front() != kNull) {
    at_ = begin;
    integer();
  }
  return good_ ? all_.substr(begin, at_ - begin) : std::string_view();
}

std::string value_text(std::string_view value) {
  if (value.empty()) return "?";
  BytesReader reader(value);
  const char head = value.front();
  if (head == kNull) return "NULL";
  if (head >= 0 && head <= kMostIntegerBytes) return std::to_string(reader.integer());
  reader.fixed(1);
  if (head == kReal) {
    char text[32];
    const auto end =
        std::to_chars(text, text + sizeof text, std::bit_cast<double>(big_endian(reader.fixed(8))));
    return {text, end.ptr};
  }
  if (head == kBlob) return "(bytes)";
  const auto length = reader.integer();
  return "'" + std::string(reader.fixed(static_cast<std::size_t>(length))) + "'";
}

}  // namespace driftwise::storage
