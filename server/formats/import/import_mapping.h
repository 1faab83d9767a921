#pragma once
// What a measurement file of another program means: the mapping file of docs/import.md as values.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/core/channel.h"
#include "server/core/rotation.h"
#include "server/core/unit_conversion.h"
#include "server/formats/import/foreign_rows.h"
#include "server/formats/import/number_style.h"
#include "server/formats/import/time_format.h"
#include "server/formats/text/text_encoding.h"

namespace driftwise::formats {

// A column of the file: by its name in the header row, or by its number from 1.
struct SourceColumn {
  std::string name;
  int number = 0;  // used when name is empty

  bool given() const { return !name.empty() || number > 0; }
};

struct FileRules {
  TableLayout layout;
  NumberStyle numbers;
  TextEncoding encoding = TextEncoding::utf_8;
  bool header = true;
  std::vector<std::string> missing = {""};  // spellings of "not measured"
};

enum class RowOrder : std::uint8_t { as_it_is, by_time };
enum class EqualTimes : std::uint8_t { refuse, spread };

struct TimeRules {
  std::vector<SourceColumn> columns;  // joined by a blank: a date column and a time column
  TimeFormat format;
  RowOrder order = RowOrder::as_it_is;
  EqualTimes equal = EqualTimes::refuse;  // spread: rows of one stamp share its resolution evenly
  double resolution_s = 1;
};

// A number of the dataset: value = convert(text * scale + offset); of a spread convert has no
// offset.
struct ColumnRule {
  // line, run, datum: whole numbers. zero: 0 or 1.
  enum class Target : std::uint8_t { channel, dwell, line, run, datum, zero };
  SourceColumn source;
  Target target = Target::channel;
  Channel channel;  // of Target::channel
  std::string unit;
  double scale = 1, offset = 0;  // in the file's unit, before the conversion
  UnitConversion convert;
  bool required = false;  // an empty field is an error
  // "t01_std": a difference, converted by the factor of its unit alone, and never negative.
  bool is_spread() const { return target == Target::channel && channel.symbol.ends_with("_std"); }
};

struct ConstantRule {
  Channel channel;
  double value = 0;
};

// Rows that are left out, and why. A row goes when the field is missing, below, above, or equal.
struct DropRule {
  SourceColumn source;
  bool missing = false;
  std::optional<double> below, above;  // in the file's unit
  std::optional<std::string> equals;
  std::string why;
};

// frame * measured * tool, as homogeneous transformations: from the body that was measured to the
// body that is wanted, and from the instrument's frame to the wanted one.
struct PoseRule {
  std::vector<std::string> position, rotation;            // channels read: three, and three or none
  std::vector<std::string> into_position, into_rotation;  // channels written; the same: replaced
  RotationConvention convention = RotationConvention::xyz_fixed, into_convention = convention;
  RigidTransform frame, tool;  // mm
};

// Rows of one goal: those whose channels lie within a distance of the group's first row.
struct GroupRule {
  std::vector<std::string> channels;
  double within = 0;               // in the channels' unit, each by itself
  std::optional<Channel> channel;  // else the dataset's line
};

struct SetRule {
  enum class By : std::uint8_t { nothing, every, share, column };
  By by = By::nothing;
  int every = 0;     // each n-th group, beginning with the n-th
  double share = 0;  // of the groups, by a hash of the seed and the group's number
  std::uint64_t seed = 1;
  SourceColumn source;  // By::column: rows whose text is one of these are for validation
  std::vector<std::string> validation;
};

struct ImportMapping {
  std::string name;  // of the mapping file, for messages
  std::string hash;  // content_hash of its text
  FileRules file;
  std::optional<TimeRules> time;
  std::vector<ColumnRule> columns;
  std::vector<ConstantRule> constants;
  std::vector<DropRule> drops;
  std::vector<PoseRule> poses;
  std::optional<GroupRule> group;
  SetRule sets;
  std::vector<std::pair<std::string, std::string>> metadata;
};

}  // namespace driftwise::formats
