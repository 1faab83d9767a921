// Counts every allocation of this program: a target must not make one.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "server/compensation/snapshot_board.h"
#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "tests/unit/compensation/models.h"

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

namespace driftwise::compensation {
namespace {

TEST(ComputeTarget, AllocatesNothing) {
  auto builder = std::move(*SnapshotBuilder::create(axis_model(), ModelId{1}, axis_cell()));
  SnapshotBoard board;
  ASSERT_TRUE(board.publish(builder.build(CellTime{1})));
  TargetRequest request;
  request.set(Variable::x,
              9);  // outside the domain, missing temperature, no datum: every flag is set
  request.set(Variable::rx, 1);     // a coordinate that the model does not know
  request.show_unreachable = true;  // beyond the soft limits
  ASSERT_TRUE(compute_target(*board.read(), request).flags & kIgnoredCoordinate);
  TargetRequest refused = request;
  refused.show_unreachable = false;
  refused.set(Variable::x, 90);
  ASSERT_EQ(compute_target(*board.read(), refused).refusal, Refusal::outside_limits);
  double sum = 0;
  const long before = allocations;
  for (int i = 0; i < 100; ++i) {
    const auto read = board.read();
    sum += compute_target(*read, request).u_nm[0] + compute_budget(*read, request, 0).u_nm;
    sum += static_cast<double>(compute_target(*read, refused).unreachable);
  }
  EXPECT_EQ(allocations - before, 0);
  EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace driftwise::compensation
