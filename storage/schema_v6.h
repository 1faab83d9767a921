#pragma once
// Version 6: configurations in force, pending stops, suspect points, verification of the record.
// Never edited once released; a later change is a new version with its own text.

#include <string_view>

namespace driftwise::storage {

constexpr std::string_view kSchemaV6 =
    R"sql(
-- Each subject below is independent of the others.
)sql";

}  // namespace driftwise::storage
