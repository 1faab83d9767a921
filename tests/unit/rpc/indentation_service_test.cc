// Indentations over gRPC on a real cell: a client's record begun, reported, continued, and judged
// by the microscope's table.

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "driftwise/v1/indentation_service.grpc.pb.h"
#include "server/formats/indentation/indentation_file.h"
#include "server/formats/indentation/procedure_json.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using Stub = v1::IndentationService::Stub;
using indentation::ProcedureRecord;
using indentation::Stage;

std::string study_file() {
  std::ifstream file(DRIFTWISE_SOURCE_DIR "/deploy/cells/two-robots/indentation.toml");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

ProcedureRecord at_contact(int contacts) {
  ProcedureRecord record;
  record.key = "a key";
  record.tool = "diamond 3";
  record.contacts = contacts;
  return record;
}

// Every indent of the study's file, made.
ProcedureRecord with_all_indents() {
  const auto file = formats::read_indentation_file(study_file(), "indentation.toml").value();
  auto record = at_contact(1);
  record.stage = Stage::microscope;
  record.zero.contact = 1;
  for (const auto& planned : file.rules.indents)
    record.indents.push_back(
        {.planned = planned, .touch = {.contact = ++record.contacts}, .rx_arcsec = -1.5});
  return record;
}

// A microscope that shows each indent 1 % too far from the zero.
std::string microscope_table(const ProcedureRecord& record) {
  std::string csv =
      "id,x_um,y_um,pixel_nm,marking_px,pictures_joined,diagonal_um\n1,0,0,140,2.5,0,\n";
  for (const auto& made : record.indents) {
    const double at_um = 1.01 * made.planned.at_um;
    const bool on_x = made.planned.line == indentation::Line::x;
    csv += fmt::format("{},{},{},140,2.5,0,\n", made.touch.contact, on_x ? at_um : 0,
                       on_x ? 0 : at_um);
  }
  return csv;
}

class IndentationServiceTest : public RpcTest {
 protected:
  Result<v1::CreateIndentationResponse> begin(const ProcedureRecord& record,
                                              const std::string& file = study_file()) {
    v1::CreateIndentationRequest request;
    request.set_key(record.key);
    request.set_file_text(file);
    request.set_record_json(formats::procedure_json(record));
    return ask(&Stub::CreateIndentation, request);
  }
  Result<v1::ReportIndentationResponse> report(std::int64_t id, const ProcedureRecord& record,
                                               const std::string& ended = {}) {
    v1::ReportIndentationRequest request;
    request.set_indentation_id(id);
    request.set_record_json(formats::procedure_json(record));
    request.set_ended(ended);
    return ask(&Stub::ReportIndentation, request);
  }
  Result<v1::ImportIndentTableResponse> import_table(std::int64_t id, const std::string& csv) {
    v1::ImportIndentTableRequest request;
    request.set_indentation_id(id);
    request.set_microscope_csv(csv);
    return ask(&Stub::ImportIndentTable, request);
  }
  v1::GetIndentationResponse get(std::int64_t id) {
    v1::GetIndentationRequest request;
    request.set_indentation_id(id);
    return ask(&Stub::GetIndentation, request).value();
  }
};

TEST_F(IndentationServiceTest, KeepsTheRecordThatAClientReports) {
  const auto begun = begin(at_contact(0));
  ASSERT_TRUE(begun) << begun.error().message;
  const auto id = begun->indentation().id();
  auto record = at_contact(2);
  record.in_contact = true;
  record.log = {"align: three contacts"};
  const auto reported = report(id, record);
  ASSERT_TRUE(reported) << reported.error().message;
  const auto shown = get(id);
  EXPECT_EQ(shown.indentation().name(), "case C.2");
  EXPECT_EQ(shown.indentation().stage(), "align");
  EXPECT_EQ(shown.indentation().contact_count(), 2);
  EXPECT_EQ(shown.indentation().planned_indent_count(), 10);
  EXPECT_TRUE(shown.indentation().in_contact());
  EXPECT_EQ(shown.indentation().created_by(), "ada");
  EXPECT_EQ(shown.record_json(), formats::procedure_json(record));
  EXPECT_EQ(shown.file_text(), study_file());
  EXPECT_EQ(shown.table_json(), "");
}

TEST_F(IndentationServiceTest, ContinuesTheIndentationOfTheKey) {
  const auto id = begin(at_contact(0))->indentation().id();
  ASSERT_TRUE(report(id, at_contact(3), "interrupted"));
  EXPECT_EQ(get(id).indentation().ended(), "interrupted");
  const auto again = begin(at_contact(3));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->indentation().id(), id);
  EXPECT_EQ(get(id).indentation().ended(), "") << "it is under way again";
  auto other = at_contact(0);
  other.key = "another key";
  EXPECT_NE(begin(other)->indentation().id(), id);
  EXPECT_EQ(ask(&Stub::ListIndentations, {})->indentations_size(), 2);
}

TEST_F(IndentationServiceTest, RefusesARecordThatCannotContinueTheStoredOne) {
  const auto id = begin(at_contact(4))->indentation().id();
  const auto older = begin(at_contact(2));
  EXPECT_THAT(older, FailsWith(ErrorCode::failed_precondition, "NOT_NOW"));
  EXPECT_THAT(older.error().message, testing::HasSubstr("has 2 contacts, the daemon's has 4"));
  auto other_tool = at_contact(4);
  other_tool.tool = "diamond 4";
  EXPECT_THAT(report(id, other_tool), FailsWith(ErrorCode::failed_precondition, "OTHER_TOOL"));
  EXPECT_THAT(report(id + 1, at_contact(4)), FailsWith(ErrorCode::not_found, "NO_SUCH_RECORD"));
  EXPECT_EQ(get(id).indentation().contact_count(), 4);
}

// The number of a contact goes back where nothing was touched: the record is younger all the same.
TEST_F(IndentationServiceTest, ContinuesAfterAnApproachThatTouchedNothing) {
  auto record = at_contact(0);
  const auto id = begin(record)->indentation().id();
  record.revision = 4;
  record.contacts = 1;
  record.in_contact = true;
  ASSERT_TRUE(report(id, record));
  const auto before_the_approach = record;
  record.revision = 5;
  record.contacts = 0;
  record.in_contact = false;
  const auto ended = report(id, record, "no contact in 40 steps");
  ASSERT_TRUE(ended) << ended.error().message;
  EXPECT_FALSE(get(id).indentation().in_contact());
  EXPECT_EQ(get(id).indentation().contact_count(), 0);
  EXPECT_EQ(get(id).indentation().ended(), "no contact in 40 steps");
  const auto again = begin(record);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->indentation().id(), id);
  EXPECT_THAT(begin(before_the_approach), FailsWith(ErrorCode::failed_precondition, "NOT_NOW"));
}

TEST_F(IndentationServiceTest, SaysThatThePicturesCannotTell) {
  const auto record = with_all_indents();
  const auto id = begin(record)->indentation().id();
  std::string exact =
      "id,x_um,y_um,pixel_nm,marking_px,pictures_joined,diagonal_um\n1,0,0,140,2.5,0,\n";
  for (const auto& made : record.indents) {
    const bool on_x = made.planned.line == indentation::Line::x;
    exact += fmt::format("{},{},{},140,2.5,0,\n", made.touch.contact, on_x ? made.planned.at_um : 0,
                         on_x ? 0 : made.planned.at_um);
  }
  const auto imported = import_table(id, exact);
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->indentation().conformity(), v1::INDENT_CONFORMITY_UNDECIDED)
      << "U is 0.7 um, wanted are 0.2";
  EXPECT_THAT(imported->indentation().verdict(),
              testing::StartsWith("cannot be told with these pictures"));
  EXPECT_EQ(nlohmann::json::parse(imported->table_json()).at("conformity"), "undecided");
}

TEST_F(IndentationServiceTest, RefusesTextsThatAreNoIndentation) {
  EXPECT_THAT(begin(at_contact(0), "name = "),
              FailsWith(ErrorCode::invalid_argument, "TOML_SYNTAX"));
  v1::CreateIndentationRequest request;
  request.set_key("a key");
  request.set_file_text(study_file());
  request.set_record_json("{\"stage\":");
  EXPECT_THAT(ask(&Stub::CreateIndentation, request),
              FailsWith(ErrorCode::invalid_argument, "JSON_SYNTAX"));
  request.set_record_json(formats::procedure_json({}));
  request.set_key("");
  EXPECT_THAT(ask(&Stub::CreateIndentation, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_VALUE"));
  EXPECT_EQ(ask(&Stub::ListIndentations, {})->indentations_size(), 0);
}

TEST_F(IndentationServiceTest, ComputesTheTableOfIndentsAndItsVerdict) {
  const auto record = with_all_indents();
  const auto id = begin(record)->indentation().id();
  const auto imported = import_table(id, microscope_table(record));
  ASSERT_TRUE(imported) << imported.error().message;
  const auto table = nlohmann::json::parse(imported->table_json());
  EXPECT_EQ(table.at("driftwise_indents"), 1);
  ASSERT_EQ(table.at("indents").size(), 10u);
  for (const auto& row : table.at("indents"))
    EXPECT_NEAR(row.at("error_um").get<double>(), 0.01 * row.at("wanted_um").get<double>(), 1e-9)
        << "1 % of the distance";
  EXPECT_EQ(imported->indentation().conformity(), v1::INDENT_CONFORMITY_BEYOND)
      << "10 um at 1 mm, wanted are 0.2";
  EXPECT_EQ(imported->indentation().verdict(), table.at("verdict"));
  EXPECT_EQ(get(id).table_json(), imported->table_json());
}

TEST_F(IndentationServiceTest, RefusesATableBeforeAllIndentsAreMade) {
  auto record = with_all_indents();
  record.stage = Stage::indents;
  record.indents.pop_back();
  const auto id = begin(record)->indentation().id();
  const auto refused = import_table(id, microscope_table(record));
  EXPECT_THAT(refused, FailsWith(ErrorCode::failed_precondition, "NOT_NOW"));
  EXPECT_THAT(refused.error().message, testing::HasSubstr("9 of 10 indents are made"));
  EXPECT_EQ(get(id).indentation().verdict(), "");
}

}  // namespace
}  // namespace driftwise::tests
