#include "server/rpc/shared/whole_texts.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <stdexcept>
#include <vector>

#include "server/core/reasons.h"

namespace driftwise::rpc {
namespace {

using namespace std::chrono_literals;

class WholeTextsTest : public testing::Test {
 protected:
  void open(WholeTexts::Limits limits) { texts = WholeTexts::make(context.get_executor(), limits); }
  std::unique_ptr<WholeTexts::Text> ask(std::string text) {
    return texts->ask([this, text = std::move(text)] { return give(text); }, [] {});
  }
  Awaitable<Result<std::string>> give(std::string text) {
    ++made;
    co_return text;
  }
  void go_on() {
    context.restart();
    context.poll();
  }
  static std::string take_all(WholeTexts::Text& text) {
    std::string out;
    while (const auto piece = text.next()) {
      EXPECT_LE(piece->size(), WholeTexts::kPieceBytes);
      out += *piece;
    }
    return out;
  }
  static std::string reason_of(const WholeTexts::Text& text) {
    const auto end = text.ended();
    if (!end) return "not over";
    return *end ? "" : std::string((*end).error().reason);
  }

  asio::io_context context;
  std::shared_ptr<WholeTexts> texts;
  int made = 0;
};

TEST_F(WholeTextsTest, ComeInPiecesAndWhole) {
  open({});
  std::string text;
  for (int i = 0; i < 40'000; ++i) text += std::to_string(i);
  const auto asked = ask(text);
  EXPECT_FALSE(asked->next());
  EXPECT_FALSE(asked->ended());
  go_on();
  EXPECT_EQ(asked->bytes(), text.size());
  EXPECT_EQ(take_all(*asked), text);
  EXPECT_EQ(reason_of(*asked), "");
  EXPECT_EQ(texts->held_bytes(), 0U) << "what went out is held no longer";
}

TEST_F(WholeTextsTest, OfManyClientsThatTakeNothingAreHeldWithinTheBudget) {
  open({.bytes = 1000, .stalled = 0ms, .patience = 1h});
  std::vector<std::unique_ptr<WholeTexts::Text>> stalled;
  for (int i = 0; i < 40; ++i) {
    stalled.push_back(ask(std::string(300, 'x')));
    go_on();
    EXPECT_LE(texts->held_bytes(), 1300U) << "after " << i + 1;
  }
  EXPECT_EQ(made, 40) << "each newcomer is served";
  EXPECT_EQ(reason_of(*stalled.front()), "BUSY") << "the one that stood for longest made room";
  EXPECT_EQ(take_all(*stalled.back()).size(), 300U);
}

TEST_F(WholeTextsTest, WaitForRoomWhereOthersTakeTheirs) {
  open({.bytes = 500, .stalled = 1h, .patience = 1h});
  const auto first = ask(std::string(300, 'a')), second = ask(std::string(300, 'b')),
             third = ask(std::string(300, 'c'));
  go_on();
  EXPECT_EQ(made, 2);
  EXPECT_FALSE(third->ended());
  EXPECT_EQ(take_all(*first), std::string(300, 'a'));
  go_on();
  EXPECT_EQ(take_all(*third), std::string(300, 'c'));
}

TEST_F(WholeTextsTest, AreRefusedAfterAWaitWithoutRoom) {
  open({.bytes = 500, .stalled = 1h, .patience = 0ms});
  const auto first = ask(std::string(300, 'a')), second = ask(std::string(300, 'b')),
             third = ask(std::string(300, 'c'));
  go_on();
  EXPECT_EQ(made, 2);
  EXPECT_EQ(reason_of(*third), "BUSY");
  EXPECT_EQ(take_all(*second), std::string(300, 'b')) << "who came before keeps his";
}

TEST_F(WholeTextsTest, AreFreeWhenTheClientGoes) {
  open({.bytes = 500, .stalled = 1h, .patience = 1h});
  auto first = ask(std::string(600, 'a'));
  go_on();
  const auto second = ask(std::string(300, 'b'));
  auto third = ask(std::string(300, 'c'));
  go_on();
  EXPECT_EQ(made, 1);
  third.reset();  // it went while it waited
  first.reset();
  go_on();
  EXPECT_EQ(made, 2);
  EXPECT_EQ(take_all(*second), std::string(300, 'b'));
}

TEST_F(WholeTextsTest, EndWithTheErrorOfTheirMaking) {
  open({});
  const auto refused = texts->ask(
      [] {
        return []() -> Awaitable<Result<std::string>> {
          co_return fail(ErrorCode::not_found, reasons::kNoRun, "no such run");
        }();
      },
      [] {});
  const auto bug = texts->ask(
      []() -> Awaitable<Result<std::string>> { throw std::runtime_error("no page"); }, [] {});
  const auto good = ask("text");
  go_on();
  EXPECT_EQ(reason_of(*refused), "NO_RUN");
  EXPECT_EQ(reason_of(*bug), "BUG");
  EXPECT_EQ(take_all(*good), "text");
}

}  // namespace
}  // namespace driftwise::rpc
