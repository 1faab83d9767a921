// Accuracy is one number with one definition: a script that knows the definition and the exported
// rows only finds what page, command line, gRPC, report and JSON show.

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>

#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "driftwise/v1/model_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"
#include "server/core/text/quantity_text.h"
#include "tests/integration/cell/cell_at_work.h"
#include "tests/support/http_client.h"

namespace driftwise::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr double kSame = 1e-9;  // of a figure: sums are taken in another order

json by_script(const std::string& what, const std::string& file) {
  const auto done = run_process(
      {"/usr/bin/python3",
       std::string(DRIFTWISE_SOURCE_DIR) + "/tests/integration/cell/accuracy_of_rows.py", what,
       file},
      std::chrono::seconds(60));
  if (done.code != 0) throw std::runtime_error(done.err);
  return json::parse(done.out);
}

// Two axes. The validation rows of q2 lie 30 nm off, so that its mean decides; t05 wanders slowly.
std::string two_axes() {
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0, 8e-6);
  std::ostringstream csv;
  csv.precision(12);
  csv << "time_s,set,zero,q1_mm,q2_mm,x_mm,y_mm,x_target_mm,y_target_mm,t05_degC\n";
  for (int i = 0; i < 240; ++i) {
    const double x = -4 + 0.5 * (i % 17), y = -3 + 0.4 * (i % 13),
                 t = 20 + 0.5 * std::sin(i / 40.0);
    const bool validation = i % 4 == 3;
    csv << 20 * i << ',' << (validation ? "validation" : "calibration") << ','
        << (i % 24 == 0 ? 1 : 0) << ',' << x + 2e-5 * x * x + 4e-4 * (t - 20) + noise(random) << ','
        << y - 3e-4 * (t - 20) + noise(random) + (validation ? 30e-6 : 0) << ',' << x << ',' << y
        << ',' << x + 45e-6 + noise(random) << ',' << y + noise(random) << ',' << t << '\n';
  }
  return csv.str();
}

template <class Response, class Request>
Response through_the_page(const CellAtWork& cell, const std::string& method,
                          const Request& request) {
  HttpClient client(cell.http_address());
  const auto reply =
      unframed(client
                   .post("/driftwise.v1." + method, "Content-Type: application/grpc-web+proto\r\n",
                         framed(request.SerializeAsString()))
                   .body);
  Response response;
  if (reply.status != 0 || reply.messages.empty() ||
      !response.ParseFromString(reply.messages.front()))
    throw std::runtime_error(method + " through the web door: " + reply.trailers);
  return response;
}

void expect_same(const json& script, const v1::JudgedAccuracy& shown) {
  EXPECT_EQ(shown.output(), script.at("output"));
  EXPECT_EQ(shown.rows(), script.at("rows"));
  EXPECT_EQ(shown.unit(), script.at("unit"));
  EXPECT_EQ(shown.figures().row_count(), script.at("count"));
  EXPECT_NEAR(shown.figures().a90() / script.at("a90").get<double>(), 1, kSame);
  EXPECT_NEAR(shown.figures().u90() / script.at("u90").get<double>(), 1, kSame);
  EXPECT_NEAR(shown.figures().mean(), script.at("mean").get<double>(),
              kSame * script.at("a90").get<double>());
}

// "42.3 nm (q2, validation rows, ...": as people read the script's figure.
std::string in_words(const json& script, const std::string& rows) {
  return digits_text(script.at("a90")) + " nm (" + script.at("output").get<std::string>() + ", " +
         rows + ", mean " + digits_text(script.at("mean"), 3, true) + " nm, S90 " +
         digits_text(script.at("u90")) + " nm)";
}

class OneAccuracy : public testing::Test {
 protected:
  // The page of this cell is its folder: a report's template that holds the data alone.
  OneAccuracy() {
    cell.write("index.html", "<html></html>");
    cell.write("report.html", "<script type=\"application/json\" id=\"report-data\">null</script>");
    cell.edit_cell_file("[clock]", "[web]\nroot = \"" + cell.folder() + "\"\n\n[clock]");
    cell.start_daemon();
    csv = cell.write("two_axes.csv", two_axes());
    cell.say({"data", "import", csv});
  }
  CellAtWork cell;
  std::string csv;
};

TEST_F(OneAccuracy, OfAModelIsTheSameEverywhere) {
  const auto fit = cell.ask({"fit", "--run", "1", "--model", "q ~ x + y + x^2 + t05"});
  const auto number = fit.at("model_id").get<int>();
  const auto id = std::to_string(number);
  const auto rows = cell.folder() + "/residuals.csv";
  cell.say({"model", "residuals", id, "-o", rows});
  const auto script = by_script("residuals", rows);
  ASSERT_EQ(script.at("heading").size(), 1u);
  const auto& heading = script.at("heading").at(0);
  EXPECT_EQ(heading.at("output"), "q2");
  EXPECT_EQ(heading.at("rows"), "validation");
  EXPECT_GT(heading.at("mean").get<double>(), 25);
  EXPECT_GT(heading.at("a90").get<double>(), 2 * heading.at("u90").get<double>());

  // JSON of the fit: every output, both kinds of rows, and the heading.
  for (const auto& one : script.at("figures")) {
    const auto& output = fit.at("outputs").at(one.at("output").get<std::string>());
    const auto key = one.at("rows").get<std::string>() + "_nm";
    EXPECT_NEAR(output.at("a90_" + key).get<double>() / one.at("a90").get<double>(), 1, kSame);
    EXPECT_NEAR(output.at("u90_" + key).get<double>() / one.at("u90").get<double>(), 1, kSame);
    EXPECT_NEAR(output.at("mean_" + key).get<double>(), one.at("mean").get<double>(),
                kSame * one.at("a90").get<double>());
  }
  ASSERT_EQ(fit.at("accuracy").size(), 1u);
  EXPECT_EQ(fit.at("accuracy").at(0).at("output"), heading.at("output"));
  EXPECT_NEAR(fit.at("accuracy").at(0).at("a90_nm").get<double>() / heading.at("a90").get<double>(),
              1, kSame);
  // The same fit of the file, and its own export.
  const auto of_file = cell.folder() + "/file.csv";
  const auto offline =
      cell.ask({"fit", csv, "--model", "q ~ x + y + x^2 + t05", "--residuals", of_file});
  EXPECT_EQ(offline.at("accuracy"), fit.at("accuracy"));
  EXPECT_EQ(by_script("residuals", of_file).at("heading"), script.at("heading"));

  // gRPC, the page's own way to it, command line and the page to sign.
  v1::GetModelRequest request;
  request.set_model_id(number);
  v1::GetModelResponse response;
  grpc::ClientContext context;
  const auto stub = v1::ModelService::NewStub(cell.channel());
  ASSERT_TRUE(stub->GetModel(&context, request, &response).ok());
  ASSERT_EQ(response.model().accuracy_size(), 1);
  expect_same(heading, response.model().accuracy(0));
  const auto page = through_the_page<v1::GetModelResponse>(cell, "ModelService/GetModel", request);
  ASSERT_EQ(page.model().accuracy_size(), 1);
  EXPECT_EQ(page.model().accuracy(0).SerializeAsString(),
            response.model().accuracy(0).SerializeAsString());
  const auto words = in_words(heading, "validation rows");
  EXPECT_THAT(cell.say({"model", "show", id}), HasSubstr("A90 " + words));
  EXPECT_THAT(cell.say({"fit", csv, "--model", "q ~ x + y + x^2 + t05"}),
              HasSubstr("accuracy (A90) " + words));
  EXPECT_THAT(cell.say({"model", "promote", id, "--yes"}), HasSubstr("accuracy (A90) " + words));
  EXPECT_EQ(cell.ask({"model", "list"})
                .at("models")
                .at(0)
                .at("accuracy")
                .at(0)
                .at("figures")
                .at("a90")
                .get<double>(),
            response.model().accuracy(0).figures().a90());
}

TEST_F(OneAccuracy, OfAVerifiedRunIsTheSameEverywhere) {
  const auto rows = cell.folder() + "/run.csv";
  cell.say({"data", "export", "1", "-o", rows});
  const auto script = by_script("targets", rows);
  const auto& heading = script.at("heading").at(0);
  EXPECT_EQ(heading.at("output"), "x");
  EXPECT_EQ(heading.at("count"), 230);
  EXPECT_GT(heading.at("mean").get<double>(), 40);

  v1::VerifyRunsRequest request;
  request.add_run_ids(1);
  v1::VerifyRunsResponse response;
  grpc::ClientContext context;
  const auto stub = v1::RunService::NewStub(cell.channel());
  ASSERT_TRUE(stub->VerifyRuns(&context, request, &response).ok());
  ASSERT_EQ(response.accuracy_size(), 1);
  expect_same(heading, response.accuracy(0));
  const auto page =
      through_the_page<v1::VerifyRunsResponse>(cell, "RunService/VerifyRuns", request);
  EXPECT_EQ(page.accuracy(0).SerializeAsString(), response.accuracy(0).SerializeAsString());
  EXPECT_EQ(cell.ask({"run", "verify", "1"}).at("accuracy").at(0).at("figures").at("a90"),
            response.accuracy(0).figures().a90());
  EXPECT_THAT(cell.say({"run", "verify", "1"}),
              HasSubstr("accuracy (A90) of run 1: " + in_words(heading, "fresh points")));
  EXPECT_THAT(cell.say({"run", "show", "1"}), HasSubstr("uncompensated"));

  // The report: the figure stands in the page's data.
  const auto report = cell.folder() + "/run-1.html";
  cell.say({"report", "run", "1", "-o", report});
  std::ifstream file(report);
  std::stringstream text;
  text << file.rdbuf();
  const auto begin = text.str().find('>') + 1;
  const auto data = json::parse(text.str().substr(begin, text.str().rfind("</script>") - begin));
  EXPECT_EQ(data.at("verification").at("accuracy").at(0).at("figures").at("a90"),
            response.accuracy(0).figures().a90());
  EXPECT_EQ(data.at("run").at("compensation"), "uncompensated");
}

}  // namespace
}  // namespace driftwise::tests
