#include "clients/cli/core/proto_json.h"

#include <cmath>

#include "clients/cli/core/text.h"
#include "driftwise/v1/model_service.pb.h"
#include "driftwise/v1/values.pb.h"

namespace driftwise::cli {
namespace {

using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using Json = nlohmann::ordered_json;

constexpr std::string_view kDurationSuffix = "_duration";

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// STATE_RUNNING of Run.State -> "running": the part that all values share is the enum's own name.
std::string enum_text(const EnumValueDescriptor* value) {
  const std::string& zero = value->type()->value(0)->name();  // "STATE_UNSPECIFIED"
  std::string text = value->name().substr(zero.size() - std::string_view("UNSPECIFIED").size());
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

Json message_json(const Message& message) {
  const auto* type = message.GetDescriptor();
  if (type == google::protobuf::Timestamp::descriptor())
    return iso_text(static_cast<const google::protobuf::Timestamp&>(message));
  if (type == google::protobuf::Duration::descriptor())
    return seconds_of(static_cast<const google::protobuf::Duration&>(message));
  return json_from(message);
}

Json value_json(const Message& message, const FieldDescriptor* field, int index) {
  const Reflection& r = *message.GetReflection();
  const bool repeated = field->is_repeated();
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return repeated ? r.GetRepeatedInt32(message, field, index) : r.GetInt32(message, field);
    case FieldDescriptor::CPPTYPE_INT64:
      return repeated ? r.GetRepeatedInt64(message, field, index) : r.GetInt64(message, field);
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return number(repeated ? r.GetRepeatedDouble(message, field, index)
                             : r.GetDouble(message, field));
    case FieldDescriptor::CPPTYPE_FLOAT:
      return number(repeated ? r.GetRepeatedFloat(message, field, index)
                             : r.GetFloat(message, field));
    case FieldDescriptor::CPPTYPE_BOOL:
      return repeated ? r.GetRepeatedBool(message, field, index) : r.GetBool(message, field);
    case FieldDescriptor::CPPTYPE_STRING:
      return repeated ? r.GetRepeatedString(message, field, index) : r.GetString(message, field);
    case FieldDescriptor::CPPTYPE_ENUM:
      return enum_text(repeated ? r.GetRepeatedEnum(message, field, index)
                                : r.GetEnum(message, field));
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return message_json(repeated ? r.GetRepeatedMessage(message, field, index)
                                   : r.GetMessage(message, field));
    default:
      return nullptr;  // the API uses no other type
  }
}

Json list_json(const Message& message, const FieldDescriptor* field) {
  const int size = message.GetReflection()->FieldSize(message, field);
  if (field->message_type() == v1::ChannelValue::descriptor()) {
    Json object = Json::object();
    for (int i = 0; i < size; ++i) {
      const auto& value = static_cast<const v1::ChannelValue&>(
          message.GetReflection()->GetRepeatedMessage(message, field, i));
      object[value.channel()] = value.has_value() ? number(value.value()) : Json(nullptr);
    }
    return object;
  }
  Json list = Json::array();
  for (int i = 0; i < size; ++i) list.push_back(value_json(message, field, i));
  return list;
}

std::string key_of(const FieldDescriptor* field) {
  std::string key = field->name();
  if (field->message_type() == google::protobuf::Duration::descriptor() &&
      key.ends_with(kDurationSuffix))
    key.replace(key.size() - kDurationSuffix.size(), std::string::npos, "_s");
  return key;
}

// The figures that stand in the summary unit, which is nm, arcsec or whatever the output has.
bool in_summary_unit(std::string_view key) {
  return key == "rmse" || key.starts_with("u90_") || key.starts_with("a90_") ||
         key.starts_with("mean_") || key == "pure_error" || key.starts_with("contribution_");
}

void add_unit(Json& node, const std::string& unit) {
  if (node.is_array())
    for (auto& each : node) add_unit(each, unit);
  if (!node.is_object()) return;
  Json renamed = Json::object();
  for (auto& [key, value] : node.items()) {
    add_unit(value, unit);
    renamed[in_summary_unit(key) ? key + "_" + unit : key] = std::move(value);
  }
  node = std::move(renamed);
}

}  // namespace

nlohmann::ordered_json json_from(const Message& message) {
  Json out = Json::object();
  const auto* type = message.GetDescriptor();
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    if (field->is_repeated())
      out[key_of(field)] = list_json(message, field);
    else if (field->has_presence() && !message.GetReflection()->HasField(message, field))
      out[key_of(field)] = nullptr;
    else
      out[key_of(field)] = value_json(message, field, 0);
  }
  if (type == v1::ModelOutput::descriptor())
    add_unit(out, static_cast<const v1::ModelOutput&>(message).summary_unit());
  return out;
}

}  // namespace driftwise::cli
