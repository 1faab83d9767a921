#include "clients/cli/core/clean_message.h"

#include <vector>

#include "server/core/text/clean_text.h"

namespace driftwise::cli {

using google::protobuf::FieldDescriptor;

void clean_message(google::protobuf::Message& message) {
  const auto& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> set;
  reflection.ListFields(message, &set);
  for (const FieldDescriptor* field : set) {
    const bool text = field->type() == FieldDescriptor::TYPE_STRING;
    if (!text && field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) {
      if (text)
        reflection.SetString(&message, field, clean_text(reflection.GetString(message, field)));
      else
        clean_message(*reflection.MutableMessage(&message, field));
      continue;
    }
    for (int i = 0; i < reflection.FieldSize(message, field); ++i)
      if (text)
        reflection.SetRepeatedString(&message, field, i,
                                     clean_text(reflection.GetRepeatedString(message, field, i)));
      else
        clean_message(*reflection.MutableRepeatedMessage(&message, field, i));
  }
}

}  // namespace driftwise::cli
