#include "clients/cli/commands/indentation/indent_report.h"

#include <random>

#include "clients/cli/commands/indentation/indent_motors.h"
#include "clients/cli/core/input_text.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/value_or_throw.h"
#include "driftwise/v1/indentation_service.grpc.pb.h"
#include "server/core/reasons.h"
#include "server/formats/indentation/procedure_json.h"

namespace driftwise::cli {
namespace {

using Stub = v1::IndentationService::Stub;
using Json = nlohmann::ordered_json;

constexpr int kMostListed = 1000;

std::string fresh_key() {
  std::random_device random;
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string key;
  for (int i = 0; i < 32; ++i) key += kDigits[random() % 16];
  return key;
}

v1::GetIndentationResponse stored(const Connection& connection, std::int64_t id) {
  v1::GetIndentationRequest request;
  request.set_indentation_id(id);
  return connection.ask(&Stub::GetIndentation, request);
}

v1::ListIndentationsResponse listed(const Connection& connection) {
  v1::ListIndentationsRequest request;
  request.set_limit(kMostListed);
  return connection.ask(&Stub::ListIndentations, request);
}

Json parsed_or_null(const std::string& text) { return text.empty() ? Json() : Json::parse(text); }

}  // namespace

IndentReport::IndentReport(const Connection& connection, const Console& console,
                           const std::string& file_text, indentation::ProcedureRecord& record)
    : connection_(connection.uninterrupted()), console_(console) {
  if (record.key.empty()) record.key = fresh_key();
  v1::CreateIndentationRequest request;
  request.set_key(record.key);
  request.set_file_text(file_text);
  request.set_record_json(formats::procedure_json(record));
  id_ = connection.ask(&Stub::CreateIndentation, request).indentation().id();
}

void IndentReport::report(const indentation::ProcedureRecord& record, const std::string& ended) {
  v1::ReportIndentationRequest request;
  request.set_indentation_id(id_);
  request.set_record_json(formats::procedure_json(record));
  request.set_ended(ended);
  try {
    connection_.ask(&Stub::ReportIndentation, request);
    is_lost_ = false;
  } catch (const Failure& failure) {
    if (!is_lost_)
      console_.err << "indentation " << id_
                   << ": the daemon did not take the record, which is complete in the file: "
                   << failure.message << '\n';
    is_lost_ = true;
  }
}

std::int64_t indentation_of_key(const Connection& connection, const std::string& key) {
  const auto answer = listed(connection);
  for (const auto& one : answer.indentations())
    if (one.key() == key) return one.id();
  throw Failure{ExitCode::refused, "not_found", reasons::kNoSuchRecord,
                "the daemon at " + connection.address() + " has no indentation of this record"};
}

void print_indentation_list(const Session& session) {
  const auto response = listed(session.connect());
  const auto& console = session.console;
  if (console.json) return console.print_json(json_from(response));
  Table table({{"indentation", Align::right},
               {"name"},
               {"tool"},
               {"stage"},
               {"contacts", Align::right},
               {"indents"},
               {"last report"},
               {"state"}});
  for (const auto& one : response.indentations())
    table.add(
        {std::to_string(one.id()), one.name(), one.tool(), one.stage(),
         std::to_string(one.contact_count()),
         std::to_string(one.indent_count()) + " of " + std::to_string(one.planned_indent_count()),
         iso_text(one.report_time()),
         !one.verdict().empty() ? one.verdict()
         : !one.ended().empty() ? one.ended()
         : one.in_contact()     ? "in contact"
                                : "no end reported"});
  table.print(console.out, console.paint_out());
}

void print_stored_indentation(const Session& session, std::int64_t id, const std::string& output) {
  const auto found = stored(session.connect(), id);
  const auto& console = session.console;
  if (!output.empty()) write_output_file(output, found.record_json());
  if (console.json) {
    Json json = json_from(found.indentation());
    json["record"] = parsed_or_null(found.record_json());
    json["table"] = parsed_or_null(found.table_json());
    if (!found.table_trouble().empty()) json["table_trouble"] = found.table_trouble();
    return console.print_json(json);
  }
  const auto& one = found.indentation();
  console.out << "indentation " << one.id() << ", " << one.name() << ": tool " << one.tool()
              << ", stage " << one.stage() << ", " << one.contact_count() << " contacts, "
              << one.indent_count() << " of " << one.planned_indent_count()
              << " indents; last report " << iso_text(one.report_time()) << '\n';
  if (one.in_contact())
    console.out << "in contact at the last report: a client that was lost leaves the robots where "
                   "they are; `driftwise indent start` with the same file retracts first\n";
  const auto record =
      value_or_throw(formats::read_procedure_json(found.record_json(), "record_json"));
  for (const auto& line : record.log) console.out << "  " << line << '\n';
  if (!one.ended().empty()) console.out << "ended: " << one.ended() << '\n';
  if (!one.verdict().empty()) console.out << "verdict: " << one.verdict() << '\n';
  if (!found.table_trouble().empty()) console.out << "table: " << found.table_trouble() << '\n';
}

}  // namespace driftwise::cli
