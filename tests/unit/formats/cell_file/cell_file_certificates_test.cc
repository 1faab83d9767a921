// [[certificate]] and identity of a cell file; the cell file without its secrets; the archive.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/formats/cell_file/cell_file_difference.h"
#include "server/formats/cell_file/without_secrets.h"
#include "server/formats/text/gzip.h"
#include "server/formats/text/tar_gz.h"

namespace driftwise::formats {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kCertified = R"([cell]
name = "small"
database = "small.db"
[[device]]
id = "laser-x"
kind = "interferometer-adapter"
address = "127.0.0.1:1"
identity = "SP-2000"
length = "x_mm"
[[certificate]]
device = "laser-x"
number = "4711"
laboratory = "PTB"
date = "2024-02-29"
due = "2026-02-28"
)";

Result<CellDescription> certified(const std::string& found = {}, const std::string& instead = {}) {
  auto text = kCertified;
  if (!found.empty()) text.replace(text.find(found), found.size(), instead);
  return parse_cell_file(text, "cell.toml", drivers::all_devices());
}

TEST(CellFileCertificates, AreReadWithTheIdentityOfTheirDevice) {
  const auto cell = certified();
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->devices.front().identity, "SP-2000");
  ASSERT_EQ(cell->certificates.size(), 1U);
  EXPECT_EQ(cell->certificates.front().number, "4711");
  // 2026-02-28T00:00:00Z is 1772236800 s.
  constexpr std::int64_t kDue_ns = 1'772'236'800'000'000'000, kDay_ns = 86'400'000'000'000;
  EXPECT_EQ(cell->certificates.front().days_left(kDue_ns), 0);
  EXPECT_EQ(cell->certificates.front().days_left(kDue_ns + kDay_ns), -1);
  EXPECT_EQ(cell->certificates.front().days_left(kDue_ns - 1), 1);
}

TEST(CellFileCertificates, ThatCannotBeAreRefusedByTheirLine) {
  EXPECT_EQ(certified("2024-02-29", "2023-02-29").error().reason, "BAD_DATE") << "no leap year";
  EXPECT_EQ(certified("2026-02-28", "2020-02-28").error().reason, "BAD_DATE") << "due before made";
  EXPECT_EQ(certified("device = \"laser-x\"", "device = \"laser-y\"").error().reason, "NO_DEVICE");
  EXPECT_THAT(certified("due = \"2026-02-28\"", "due = \"soon\"").error().message,
              HasSubstr("expected a day such as"));
}

TEST(CellFileCertificates, ChangeWithoutAQuestion) {
  for (const auto& change :
       cell_file_difference(kCertified, *certified("2026-02-28", "2028-02-28")))
    EXPECT_FALSE(change.asks) << change.place << ' ' << change.key;
  for (const auto& change : cell_file_difference(kCertified, *certified("SP-2000", "SP-5000")))
    EXPECT_FALSE(change.asks) << change.place << ' ' << change.key;
}

TEST(CellFileWithoutSecrets, IsStillTomlAndKeepsWhatIsNoSecret) {
  const auto shown =
      cell_file_without_secrets(kCertified + R"(options = { password = "hush1", units = "K" }
# hush2
[[notify]]
name = "duty"
webhook = "https://hooks.example.org/hush3"
token_file = "/etc/driftwise/hook.token"
[[notify]]
name = "chat"
command = ["/bin/send", "hush4"]
)");
  EXPECT_THAT(shown, Not(HasSubstr("hush")));
  EXPECT_THAT(shown, Not(HasSubstr("/etc/driftwise")));
  EXPECT_THAT(shown, HasSubstr("4711"));
  EXPECT_THAT(shown, HasSubstr("webhook = \"https://hooks.example.org/[removed]\""));
  EXPECT_THAT(shown, HasSubstr("token_file = \"hook.token\""));
}

TEST(CellFileWithoutSecrets, IsStillTomlWhereAKeyOrAPathNeedsQuotes) {
  const auto shown =
      cell_file_without_secrets("\"a b\" = 1\n[web]\nroot_file = 'x/say \"hi\"'\n" +
                                std::string("[\"c.d\"]\n\"e f\" = { \"g h\" = 2 }\n"));
  EXPECT_EQ(cell_file_without_secrets(shown), shown) << "read again";
  EXPECT_THAT(shown, HasSubstr("say"));
  EXPECT_THAT(shown, HasSubstr("g h"));
}

TEST(ValueWithoutSecrets, RemovesByTheKeyAndByTheFormOfTheValue) {
  const auto removed = [](std::string_view key, const std::string& value) {
    const std::string once = value_without_secrets(key, value);
    EXPECT_EQ(value_without_secrets(key, once), once) << "twice";
    return once;
  };
  EXPECT_EQ(removed("options.password", "hush"), "[removed]");
  EXPECT_EQ(removed("command", "[/bin/send, hush]"), "[removed]");
  EXPECT_EQ(removed("headers", "{token = hush}"), "[removed]");
  EXPECT_EQ(removed("webhook", "https://joe:hush@example.org:1/hush"),
            "https://example.org:1/[removed]");
  EXPECT_EQ(removed("urls", "[http://[::1]:80/hush, http://b?hush]"),
            "[http://[::1]:80/[removed], http://b/[removed]]");
  EXPECT_EQ(removed("", "name chat, command [/bin/send, hush]"), "[removed]");
  EXPECT_EQ(removed("", "name duty, webhook https://example.org/hush"),
            "name duty, webhook https://example.org/[removed]");
  for (const auto& [key, value] : {std::pair{"token_file", "/etc/hook.token"},
                                   {"input", "107"},
                                   {"webhook", "https://example.org/"},
                                   {"to", "ada@example.org"},
                                   {"", "name duty, token_file hook.token"},
                                   {"name", ""}})
    EXPECT_EQ(removed(key, value), value);
}

TEST(WithoutSecrets, RemovesWhatIsKnownAndWhatShowsItselfByItsForm) {
  const auto shown = without_secrets(
      "known hushhush; dwt_0123456789abcdef; Authorization: Bearer abcd1234; "
      "smtp://joe:sesame@mail.example.org:25; password=sesame2, "
      "-----BEGIN EC PRIVATE KEY-----\nMIIa\n-----END EC PRIVATE KEY-----\nthe end",
      {"hushhush"});
  for (const char* secret : {"hushhush", "0123456789abcdef", "abcd1234", "sesame", "MIIa"})
    EXPECT_THAT(shown, Not(HasSubstr(secret))) << shown;
  EXPECT_THAT(shown, HasSubstr("@mail.example.org:25"));
  EXPECT_THAT(shown, HasSubstr("the end"));
}

// Sizes and magic of ustar, POSIX.1-1988; gzip is undone by our own reader of .gz.
TEST(TarGz, HoldsItsMembersInBlocksOf512Bytes) {
  const auto packed =
      tar_gz({{"a/one.txt", "hello\n"}, {"a/two.txt", std::string(600, 'x')}}, 1'700'000'000);
  ASSERT_TRUE(packed);
  const auto tar = gunzip(*packed, "a.tar.gz", 1U << 20U);
  ASSERT_TRUE(tar) << tar.error().message;
  EXPECT_EQ(tar->size(), 512U * (1 + 1 + 1 + 2 + 2));
  EXPECT_EQ(tar->substr(0, 9), "a/one.txt");
  EXPECT_EQ(tar->substr(257, 5), "ustar");
  EXPECT_EQ(tar->substr(512, 6), "hello\n");
  unsigned sum = 0;
  for (std::size_t i = 0; i < 512; ++i)
    sum += i >= 148 && i < 156 ? ' ' : static_cast<unsigned char>((*tar)[i]);
  EXPECT_EQ(std::stoul(tar->substr(148, 6), nullptr, 8), sum);
  EXPECT_FALSE(tar_gz({{std::string(120, 'n'), ""}}, 0));
}

}  // namespace
}  // namespace driftwise::formats
