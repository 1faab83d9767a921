// Counts every allocation of this program: a joint target must not make one, nor its line.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "server/formats/export/target_line.h"
#include "server/plans/joint_target.h"
#include "tests/unit/plans/two_robots.h"

namespace {
std::atomic<long> allocations{0};
}  // namespace

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace driftwise::plans {
namespace {

TEST(ComputeJointTarget, AllocatesNothing) {
  using compensation::Variable;
  auto plan = joint_plan();
  auto models = joint_models();
  follow_the_tilt(models.at(kMinAngleMotion), 1e-4);  // several passes
  plan.robots[1].blend->anchored = true;
  for (auto& edge : plan.robots[1].blend->band) edge.fade_to = 1500;
  auto builder = std::move(*JointBuilder::create(plan, PlanId{1}, models, two_robot_cell()));
  JointBoard board;
  ASSERT_TRUE(board.publish(builder.build(CellTime{1})));
  JointRequest request;
  for (std::size_t robot = 0; robot < 2; ++robot)
    for (const auto v : {Variable::x, Variable::y, Variable::z, Variable::rx, Variable::ry})
      request.set(robot, v, 1.0);
  JointRequest unreachable = request;
  unreachable.set(1, Variable::z, 90);
  double sum = 0;
  bool blended = false, refused = false;
  const long before = allocations;
  for (int i = 0; i < 400; ++i) {
    const auto read = board.read();
    request.set(1, Variable::rx, i);  // the fine model, the band, where the anchor fades
    const auto target = compute_joint_target(*read, request);
    sum += target.u_nm[3];
    blended = blended || target.robot[1].by == AnsweredBy::blend;
    refused =
        compute_joint_target(*read, unreachable).refusal == compensation::Refusal::outside_limits;
  }
  EXPECT_EQ(allocations - before, 0);
  EXPECT_TRUE(blended);
  EXPECT_TRUE(refused);
  EXPECT_GT(sum, 0);
}

TEST(JointLine, AllocatesNothingFromTheQuestionToTheAnswer) {
  auto models = joint_models();
  auto builder = std::move(
      *JointBuilder::create(joint_plan(), PlanId{1}, std::move(models), two_robot_cell()));
  const auto snapshot = builder.build(CellTime{1});
  std::string out;
  out.reserve(formats::kMaxTargetAnswer);
  const auto ask = [&](std::string_view line) {
    const auto request = formats::parse_joint_line(line, snapshot);
    out.clear();
    formats::append_joint_answer(out, snapshot, compute_joint_target(snapshot, *request),
                                 request->with_uncertainty);
  };
  // Temperatures that were never read and an unknown datum: every flag with its names.
  constexpr std::string_view kLine =
      "JOINT mn.x_mm=3 mn.y_mm=0 mn.z_mm=0 ma.rx_arcsec=325 ma.ry_arcsec=0 ma.z_mm=3 "
      "mn.force_N=1 u=1";
  ask(kLine);  // the stamp of the snapshot is kept as a text
  const long before = allocations;
  for (int i = 0; i < 100; ++i) ask(kLine);
  EXPECT_EQ(allocations - before, 0);
  for (const char* flag : {"BLENDED(ma)", "OUTSIDE_DOMAIN(mn.x_mm)",
                           "MISSING_TEMPERATURE(t05_degC)", "IGNORED_COORDINATE(mn.force_N)"})
    EXPECT_NE(out.find(flag), std::string::npos) << flag << " in " << out;
}

}  // namespace
}  // namespace driftwise::plans
