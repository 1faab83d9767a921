#include "server/access/token_book.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <limits>

#include "tests/support/process.h"

namespace driftwise::access {
namespace {

constexpr ScryptCost kQuick{16, 1, 1};
constexpr std::int64_t kNow = 1'800'000'000;

class TokenBookTest : public testing::Test {
 protected:
  std::unique_ptr<TokenBook> open() {
    auto book = TokenBook::open(path, kQuick);
    if (!book) throw std::runtime_error(book.error().message);
    return std::move(*book);
  }
  tests::TemporaryFolder folder;
  std::string path = folder.path() + "/tokens.json";
};

TEST_F(TokenBookTest, KnowsATokenAgainAfterARestart) {
  const auto made = open()->create("press", Role::controller, "ada", kNow, {});
  ASSERT_TRUE(made);
  const auto book = open();
  EXPECT_EQ(book->known(made->text, kNow), std::nullopt) << "not yet checked";
  const auto checked = book->check(made->text, kNow);
  ASSERT_TRUE(checked);
  EXPECT_EQ(*checked, made->record);
  EXPECT_EQ(book->known(made->text, kNow), made->record);
  EXPECT_EQ(book->list(), std::vector{made->record});
}

TEST_F(TokenBookTest, KeepsNothingOfTheText) {
  const auto made = open()->create("press", Role::controller, "ada", kNow, {});
  const std::string file = tests::read_file(path);
  EXPECT_EQ(file.find(token_parts(made->text)->secret), std::string::npos);
  struct stat about {};
  ASSERT_EQ(::stat(path.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0600U);
}

TEST_F(TokenBookTest, RefusesWhatIsWrongWithOneSentence) {
  const auto book = open();
  const auto made = book->create("press", Role::controller, "ada", kNow, kNow + 86'400);
  const auto other = book->create("page", Role::viewer, "ada", kNow, {});
  ASSERT_TRUE(book->check(made->text, kNow));
  auto parts = *token_parts(made->text);
  const auto stranger = new_token();
  ASSERT_TRUE(book->revoke(other->record.id));
  const std::vector<std::pair<std::string, std::int64_t>> wrong = {
      {made->text, kNow + 86'400},                      // over
      {other->text, kNow},                              // revoked
      {token_text({parts.id, stranger.secret}), kNow},  // the id of another
      {token_text(stranger), kNow},                     // unknown
      {"dwt_", kNow},
      {std::string(300, 'x'), kNow}};
  std::string sentence;
  for (const auto& [text, now] : wrong) {
    const auto checked = book->check(text, now);
    ASSERT_FALSE(checked) << text;
    EXPECT_EQ(checked.error().code, ErrorCode::unauthenticated);
    if (sentence.empty()) sentence = checked.error().message;
    EXPECT_EQ(checked.error().message, sentence) << "nothing tells which";
    EXPECT_EQ(book->known(text, now), std::nullopt);
  }
}

TEST_F(TokenBookTest, RevokesAKnownTokenAtOnceAndForGood) {
  const auto book = open();
  const auto made = book->create("press", Role::controller, "ada", kNow, {});
  ASSERT_TRUE(book->check(made->text, kNow));
  ASSERT_TRUE(book->revoke(made->record.id));
  EXPECT_EQ(book->known(made->text, kNow), std::nullopt);
  EXPECT_FALSE(book->check(made->text, kNow));
  EXPECT_FALSE(open()->check(made->text, kNow));
  EXPECT_EQ(book->revoke(made->record.id).error().reason, "NO_TOKEN");
}

TEST_F(TokenBookTest, RefusesAFileThatOthersMayRead) {
  ASSERT_TRUE(open()->create("press", Role::controller, "ada", kNow, {}));
  std::filesystem::permissions(path, std::filesystem::perms::group_read,
                               std::filesystem::perm_options::add);
  EXPECT_EQ(TokenBook::open(path, kQuick).error().reason, "FILE_READABLE");
}

TEST_F(TokenBookTest, SaysWhichFileIsDamaged) {
  for (const char* text : {"", "{", "[]", R"({"tokens": [{}]})",
                           R"({"tokens": [{"id": "a", "name": "b", "role": "root"}]})"}) {
    std::filesystem::remove(path);
    tests::write_file(path, text);
    std::filesystem::permissions(
        path, std::filesystem::perms::owner_all & ~std::filesystem::perms::owner_exec);
    const auto book = TokenBook::open(path, kQuick);
    ASSERT_FALSE(book) << text;
    EXPECT_EQ(book.error().reason, "BAD_TOKENS");
    EXPECT_NE(book.error().message.find(path), std::string::npos);
  }
}

TEST_F(TokenBookTest, TakesNamesThatPeopleCanRead) {
  const auto book = open();
  for (const std::string& bad : {std::string(), std::string(65, 'a'), std::string("a\nb"),
                                 std::string("a\x1b[2J"), std::string("\xff")})
    EXPECT_EQ(book->create(bad, Role::viewer, "ada", kNow, {}).error().reason, "BAD_NAME");
  EXPECT_EQ(book->create("a", Role::viewer, "ada", kNow, kNow).error().reason, "BAD_TIME");
  EXPECT_TRUE(book->create("Zoë's press", Role::viewer, "ada", kNow, {}));
}

TEST_F(TokenBookTest, TakesAnEndWithinAHundredYears) {
  const auto book = open();
  const std::int64_t last = kNow + TokenBook::kLongest_s;
  EXPECT_TRUE(book->create("a", Role::viewer, "ada", kNow, last));
  for (const std::int64_t late : {last + 1, std::numeric_limits<std::int64_t>::max()}) {
    const auto refused = book->create("a", Role::viewer, "ada", kNow, late);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().reason, "BAD_TIME");
    EXPECT_NE(refused.error().message.find("hundred years"), std::string::npos);
  }
}

TEST_F(TokenBookTest, MakesNoTokenThatIsNotOnDisk) {
  const auto book = open();
  std::filesystem::create_directory(path);  // nothing can be put in its place
  std::filesystem::create_directory(path + "/full");
  EXPECT_EQ(book->create("press", Role::viewer, "ada", kNow, {}).error().reason, "CANNOT_WRITE");
  EXPECT_TRUE(book->list().empty());
}

}  // namespace
}  // namespace driftwise::access
