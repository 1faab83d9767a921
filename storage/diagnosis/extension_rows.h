#pragma once
// Rows of extension and correction. Each call runs inside the caller's transaction and throws
// StorageFailure.

#include <optional>
#include <vector>

#include "server/core/records/diagnosis_records.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

void require_diagnosis(Session& session, DiagnosisId id);  // throws not_found NO_SUCH_DIAGNOSIS
[[noreturn]] void throw_no_such_diagnosis(Session& session, DiagnosisId id);

ExtensionRecord insert_extension(Session& session, const NewExtension& extension);
ExtensionRecord undo_extension_row(Session& session, DiagnosisId id, const Stamp& at,
                                   const std::string& who, const std::string& from,
                                   const std::optional<PromotionRecord>& rollback);
std::optional<ExtensionRecord> read_extension(Session& session, DiagnosisId id);
std::vector<CorrectionRecord> read_corrections(Session& session);

// Numbers as a person reads them in a column: "1 3".
std::string numbers_text(const std::vector<std::int64_t>& numbers);
std::vector<std::int64_t> numbers_from(const std::string& text);

}  // namespace driftwise::storage
