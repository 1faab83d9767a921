#include "server/calibration/model/model_units.h"

#include <string_view>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::calibration {
namespace {

// The model's own channel of this symbol; "q1_cmd" is asked for as "q1". Null: it has none.
const Channel* channel_in(const Model& model, std::string_view symbol) {
  constexpr std::string_view kCommanded = "_cmd";
  for (const auto& output : model.outputs)
    if (output.channel.symbol == symbol) return &output.channel;
  for (const auto& range : model.domain)
    if (range.channel.symbol == symbol) return &range.channel;
  if (!symbol.ends_with(kCommanded)) return nullptr;
  symbol.remove_suffix(kCommanded.size());
  for (const auto& output : model.outputs)
    if (output.channel.symbol == symbol) return &output.channel;
  return nullptr;
}

}  // namespace

Result<UnitConversion> to_model_unit(const Channel& read, const Channel& of_model) {
  if (read.unit == of_model.unit) return UnitConversion{};
  auto conversion = unit_conversion(read.unit, of_model.unit);
  if (!conversion)
    return fail(ErrorCode::invalid_argument, reasons::kUnitsDisagree,
                "the model has " + of_model.symbol + " in " + of_model.unit + ", found it in " +
                    read.unit + ", which cannot be converted: give the channel in " +
                    of_model.unit + ", or fit a model in " + read.unit);
  if (read.symbol.ends_with("_std")) conversion->offset = 0;
  return conversion;
}

Result<Dataset> in_model_units(const Model& model, Dataset data) {
  for (auto& column : data.columns) {
    const Channel* own = channel_in(model, column.channel.symbol);
    if (own == nullptr || own->unit == column.channel.unit) continue;
    DRIFTWISE_TRY(const auto convert, to_model_unit(column.channel, *own));
    for (double& value : column.values) value = convert(value);
    column.channel.unit = own->unit;
  }
  return data;
}

Result<std::vector<ChannelValue>> in_model_units(const Model& model,
                                                 std::vector<ChannelValue> values) {
  for (auto& value : values) {
    auto channel = parse_robot_channel(value.channel);
    if (!channel) continue;
    const Channel* own = channel_in(model, channel->symbol);
    if (own == nullptr || own->unit == channel->unit) continue;
    DRIFTWISE_TRY(const auto convert, to_model_unit(*channel, *own));
    value.value = convert(value.value);
    channel->unit = own->unit;
    value.channel = channel->name();
  }
  return values;
}

}  // namespace driftwise::calibration
