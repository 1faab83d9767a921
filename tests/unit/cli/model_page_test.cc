// The page a metrologist signs, character by character against a file that a person has read. When
// it is meant to change: DRIFTWISE_WRITE_GOLDEN=1 writes the new page over the old; read it again.

#include "clients/cli/pages/model_page.h"

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "clients/cli/core/console.h"

namespace driftwise::cli {
namespace {

const std::string kFolder = std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/model_page/";

std::string read_whole_file(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(ModelPage, IsTheOneThatWasReadAndApproved) {
  v1::GetModelResponse shown;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(
      read_whole_file(kFolder + "model.textproto"), &shown));
  std::ostringstream out, err;
  const std::map<std::string, std::string> environment;
  const Console console{out, err, false, false, 80, environment, ".", false, 24};
  print_model_page(console, shown);
  if (std::getenv("DRIFTWISE_WRITE_GOLDEN") != nullptr)
    std::ofstream(kFolder + "page.txt") << out.str();
  EXPECT_EQ(out.str(), read_whole_file(kFolder + "page.txt"));
}

}  // namespace
}  // namespace driftwise::cli
