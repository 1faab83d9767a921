#include "server/formats/diagnosis/amendment_json.h"

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"
#include "server/formats/text/json_place.h"

namespace driftwise::formats {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kAmendmentSchema = "driftwise.correction.v1";

Json shift_json(const correction::LengthShift& shift) {
  Json one{{"axis", shift.axis},
           {"terms", Json::array()},
           {"runs", Json::array()},
           {"clock_origin_ns", shift.clock_origin.utc_ns}};
  for (const RunId run : shift.runs) one["runs"].push_back(run.value);
  if (!shift.device.empty()) one["device"] = shift.device;
  for (std::size_t j = 0; j < shift.terms.size(); ++j)
    one["terms"].push_back(
        {{"term", effects::notation(shift.terms[j])}, {"mm", json_number(shift.mm[j])}});
  return one;
}

correction::LengthShift read_shift(const JsonPlace& from) {
  correction::LengthShift shift;
  shift.axis = from["axis"].text();
  const auto terms = from["terms"];
  for (std::size_t j = 0; j < terms.size(); ++j) {
    auto term = parse_term(terms[j]["term"].text());
    if (!term) terms[j]["term"].refuse("a term of a formula");
    shift.terms.push_back(std::move(*term));
    shift.mm.push_back(terms[j]["mm"].finite());
  }
  const auto runs = from["runs"];
  for (std::size_t i = 0; i < runs.size(); ++i) shift.runs.push_back({runs[i].integer(1)});
  shift.clock_origin.utc_ns = from["clock_origin_ns"].integer();
  if (from.has("device")) shift.device = from["device"].text();
  return shift;
}

Json angle_json(const correction::AngleShift& shift) {
  Json one{{"axis", shift.axis},
           {"source", shift.source},
           {"terms", Json::array()},
           {"runs", Json::array()},
           {"clock_origin_ns", shift.clock_origin.utc_ns}};
  for (const RunId run : shift.runs) one["runs"].push_back(run.value);
  for (std::size_t j = 0; j < shift.terms.size(); ++j)
    one["terms"].push_back({{"term", effects::notation(shift.terms[j])},
                            {"arcsec", json_number(shift.arcsec[j])},
                            {"u_arcsec", json_number(shift.u_arcsec[j])}});
  return one;
}

correction::AngleShift read_angle(const JsonPlace& from) {
  correction::AngleShift shift;
  shift.axis = from["axis"].text();
  shift.source = from["source"].text();
  const auto terms = from["terms"];
  for (std::size_t j = 0; j < terms.size(); ++j) {
    auto term = parse_term(terms[j]["term"].text());
    if (!term) terms[j]["term"].refuse("a term of a formula");
    shift.terms.push_back(std::move(*term));
    shift.arcsec.push_back(terms[j]["arcsec"].finite());
    shift.u_arcsec.push_back(terms[j]["u_arcsec"].finite());
    if (shift.u_arcsec.back() < 0) terms[j]["u_arcsec"].refuse("a number from 0");
  }
  const auto runs = from["runs"];
  for (std::size_t i = 0; i < runs.size(); ++i) shift.runs.push_back({runs[i].integer(1)});
  shift.clock_origin.utc_ns = from["clock_origin_ns"].integer();
  return shift;
}

correction::DataAmendment read_amendment(const JsonPlace& from) {
  if (from["schema"].text() != kAmendmentSchema) from["schema"].refuse(kAmendmentSchema);
  correction::DataAmendment amendment;
  const auto shifts = from["shifts"];
  for (std::size_t i = 0; i < shifts.size(); ++i) amendment.shifts.push_back(read_shift(shifts[i]));
  const auto splits = from["datum_splits"];
  for (std::size_t i = 0; i < splits.size(); ++i)
    amendment.splits.push_back({{splits[i]["run"].integer(1)}, splits[i]["row"].integer(0)});
  const auto sensors = from["sensors_left_out"];
  for (std::size_t i = 0; i < sensors.size(); ++i)
    amendment.sensors.push_back({{sensors[i]["run"].integer(1)}, sensors[i]["sensor"].text()});
  if (from.has("angles")) {  // a correction without them was written before there were any
    const auto angles = from["angles"];
    for (std::size_t i = 0; i < angles.size(); ++i)
      amendment.angles.push_back(read_angle(angles[i]));
  }
  return amendment;
}

}  // namespace

std::string write_amendment_json(const correction::DataAmendment& amendment) {
  Json json{{"schema", kAmendmentSchema},
            {"shifts", Json::array()},
            {"datum_splits", Json::array()},
            {"sensors_left_out", Json::array()}};
  for (const auto& shift : amendment.shifts) json["shifts"].push_back(shift_json(shift));
  for (const auto& split : amendment.splits)
    json["datum_splits"].push_back({{"run", split.run.value}, {"row", split.row}});
  for (const auto& sensor : amendment.sensors)
    json["sensors_left_out"].push_back({{"run", sensor.run.value}, {"sensor", sensor.symbol}});
  // Left out where there are none: the text of every other correction stays as it was.
  for (const auto& shift : amendment.angles) json["angles"].push_back(angle_json(shift));
  return json.dump();
}

Result<correction::DataAmendment> read_amendment_json(std::string_view text) {
  DRIFTWISE_TRY(const auto json, parse_json(text));
  try {
    return read_amendment(JsonPlace(json, ""));
  } catch (const JsonProblem& problem) {
    return fail(ErrorCode::invalid_argument, reasons::kBadCorrection,
                "correction: " + problem.place + ": found " + problem.found + ", expected " +
                    problem.expected);
  }
}

}  // namespace driftwise::formats
