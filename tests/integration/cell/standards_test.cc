// ISO 230-2 on the simulated axis: the generated trajectory, run over the wire, has its figures;
// another run is refused with what it lacks.

#include <gmock/gmock.h>
#include <grpcpp/channel.h>

#include "driftwise/v1/standards_service.grpc.pb.h"
#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

TEST(Standards, FiguresOfAnAxisComeFromTheTrajectoryThatIsMadeForThem) {
  CellAtWork cell;
  cell.start_daemon();
  const auto file = cell.folder() + "/iso.csv";
  cell.say({"trajectory", "iso230-2", "--from", "-3", "--to", "3", "--positions", "5",
            "--approaches", "6", "-o", file});
  EXPECT_EQ(cell.cli({"trajectory", "check", file}).code, 0);
  const auto watched = cell.cli({"run", "start", file, "--watch"});
  ASSERT_EQ(watched.code, 0) << watched.err;

  const auto figures = cell.ask({"standard", "iso230-2", "--run", "1"});
  ASSERT_EQ(figures.at("positions").size(), 5U) << figures;
  const double a_nm = figures.at("a").at("both_nm"), r_nm = figures.at("r").at("both_nm");
  EXPECT_GT(r_nm, 0);
  EXPECT_GE(a_nm, r_nm / 2) << "the band of one position lies within that of all";
  EXPECT_GE(a_nm, figures.at("e").at("both_nm").get<double>());
  EXPECT_LT(a_nm, 1e5) << "an axis with a scale, not one without";
  EXPECT_EQ(figures.at("turning_points_mm").size(), 2U);
  EXPECT_FALSE(figures.at("conditions").at("temperatures").empty());
  EXPECT_THAT(cell.say({"standard", "iso230-2", "--run", "1"}),
              testing::HasSubstr("5 positions, 5 approaches from each side"));

  // The API gives the same numbers, and an exported file too.
  v1::StandardsService::Stub stub(cell.channel());
  grpc::ClientContext context;
  v1::EvaluateIso2302Request request;
  request.add_run_ids(1);
  v1::EvaluateIso2302Response response;
  const auto status = stub.EvaluateIso2302(&context, request, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.a().both_nm(), a_nm);
  EXPECT_EQ(response.positions(2).down().s_nm(),
            figures.at("positions").at(2).at("down").at("s_nm").get<double>());
  const auto exported = cell.folder() + "/run.csv";
  cell.say({"data", "export", "1", "-o", exported});
  EXPECT_EQ(cell.ask({"standard", "iso230-2", exported}).at("a").at("both_nm"), a_nm);

  // Rows that are kept out are no figures, but the next row still comes from them: by both ways.
  cell.say({"data", "exclude", "1", "--rows", "7-8", "--reason", "touched"});
  const auto without = cell.ask({"standard", "iso230-2", "--run", "1"});
  EXPECT_NE(without.at("positions").at(4).at("up"), figures.at("positions").at(4).at("up"));
  grpc::ClientContext again;
  v1::EvaluateIso2302Response kept_out;
  ASSERT_TRUE(stub.EvaluateIso2302(&again, request, &kept_out).ok());
  EXPECT_EQ(kept_out.a().both_nm(), without.at("a").at("both_nm").get<double>());
  EXPECT_EQ(kept_out.b_nm(), without.at("b_nm").get<double>());
}

TEST(Standards, ARunWithoutApproachesFromBothSidesIsRefused) {
  CellAtWork cell;
  cell.start_daemon();
  ASSERT_EQ(cell.end_of(cell.start_run(campaign(1, 6))).at("state"), "done");
  const auto refused = cell.cli({"standard", "iso230-2", "--run", "1", "--json"});
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.err, testing::HasSubstr("LACKS_APPROACHES"));
  EXPECT_THAT(refused.err, testing::HasSubstr("from above"));
}

}  // namespace
}  // namespace driftwise::tests
