#include "server/rpc/shared/request_texts.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::rpc {
namespace {

using google::protobuf::FieldDescriptor;

bool holds_a_file(const FieldDescriptor& field) {
  static constexpr std::array<std::string_view, 6> kFiles = {
      "file_text", "microscope_csv", "record_json", "robot_toml", "text", "trajectory_text"};
  return std::ranges::find(kFiles, field.name()) != kFiles.end();
}

// found_bytes: of the texts so far; grows.
Result<void> check_texts_in(const google::protobuf::Message& message, const std::string& above,
                            std::size_t& found_bytes) {
  const auto& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> set;
  reflection.ListFields(message, &set);
  for (const FieldDescriptor* field : set) {
    const bool is_text = field->type() == FieldDescriptor::TYPE_STRING && !holds_a_file(*field);
    if (!is_text && field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    const bool is_repeated = field->is_repeated();
    const int count = is_repeated ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const std::string place =
          above + field->name() + (is_repeated ? "[" + std::to_string(i) + "]" : "");
      if (is_text) {
        std::string scratch;
        const std::string& text =
            is_repeated ? reflection.GetRepeatedStringReference(message, field, i, &scratch)
                        : reflection.GetStringReference(message, field, &scratch);
        DRIFTWISE_RETURN_IF_ERROR(check_size(text, kMostTextBytes, place));
        found_bytes += text.size();
        continue;
      }
      const google::protobuf::Message& inner =
          is_repeated ? reflection.GetRepeatedMessage(message, field, i)
                      : reflection.GetMessage(message, field);
      DRIFTWISE_RETURN_IF_ERROR(check_texts_in(inner, place + ".", found_bytes));
    }
  }
  return {};
}

}  // namespace

Result<void> check_texts(const google::protobuf::Message& request) {
  if (request.ByteSizeLong() <= kMostTextBytes) return {};
  std::size_t found_bytes = 0;
  DRIFTWISE_RETURN_IF_ERROR(check_texts_in(request, "", found_bytes));
  if (found_bytes <= kMostTextsBytes) return {};
  return fail(ErrorCode::invalid_argument, reasons::kTooLong,
              "texts of the request: found " + std::to_string(found_bytes) +
                  " bytes together, expected at most " + std::to_string(kMostTextsBytes));
}

}  // namespace driftwise::rpc
