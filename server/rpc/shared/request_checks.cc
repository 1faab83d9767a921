#include "server/rpc/shared/request_checks.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::rpc {

Result<void> check_id(std::int64_t id, std::string_view field) {
  if (id > 0) return {};
  return fail(ErrorCode::invalid_argument, reasons::kBadId,
              std::string(field) + ": found " + std::to_string(id) + ", expected a number from 1");
}

Result<void> check_cursor(std::int64_t cursor, std::string_view field) {
  if (cursor >= 0) return {};
  return fail(
      ErrorCode::invalid_argument, reasons::kBadCursor,
      std::string(field) + ": found " + std::to_string(cursor) + ", expected a number from 0");
}

Result<int> limit_from(std::int32_t limit, int usual, int most) {
  if (limit == 0) return usual;
  if (limit > 0 && limit <= most) return limit;
  return fail(ErrorCode::invalid_argument, reasons::kBadLimit,
              "limit: found " + std::to_string(limit) + ", expected 0 (meaning " +
                  std::to_string(usual) + ") to " + std::to_string(most));
}

Result<void> check_size(std::string_view text, std::size_t most_bytes, std::string_view field) {
  if (text.size() <= most_bytes) return {};
  return fail(ErrorCode::invalid_argument, reasons::kTooLong,
              std::string(field) + ": found " + std::to_string(text.size()) +
                  " bytes, expected at most " + std::to_string(most_bytes));
}

Result<std::string> line_from(std::string_view text, std::size_t most_bytes,
                              std::string_view field) {
  DRIFTWISE_RETURN_IF_ERROR(check_size(text, most_bytes, field));
  return clean_line(text);
}

Result<std::vector<RunId>> run_ids_from(const google::protobuf::RepeatedField<std::int64_t>& ids) {
  constexpr int kMostRuns = 1000;
  if (ids.size() > kMostRuns)
    return fail(ErrorCode::invalid_argument, reasons::kTooManyRuns,
                "run_ids: found " + std::to_string(ids.size()) + ", expected at most 1000");
  std::vector<RunId> runs;
  for (const std::int64_t id : ids) {
    DRIFTWISE_RETURN_IF_ERROR(check_id(id, "run_ids"));
    if (std::find(runs.begin(), runs.end(), RunId{id}) != runs.end())
      return fail(ErrorCode::invalid_argument, reasons::kDuplicateRun,
                  "run_ids: run " + std::to_string(id) + " stands twice");
    runs.push_back({id});
  }
  return runs;
}

}  // namespace driftwise::rpc
