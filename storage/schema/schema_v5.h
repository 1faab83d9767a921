#pragma once
// Version 5: what happens to diagnoses and improvements is numbered, so that who watches by a
// cursor misses none of it. Never edited once released; a change is a new version with its own
// text.

#include <string_view>

namespace driftwise::storage {

// Written by the database itself: whoever changes a state, marks unfinished ones as failed at a
// start or undoes an extension cannot forget to say so.
constexpr std::string_view kSchemaV5 =
    R"sql(
CREATE TABLE job_change (  -- one row: something was said of a diagnosis or of an improvement
  change INTEGER PRIMARY KEY,
  diagnosis_id INTEGER REFERENCES diagnosis (diagnosis_id),
  improvement_id INTEGER REFERENCES improvement (improvement_id),
  CHECK ((diagnosis_id IS NULL) <> (improvement_id IS NULL))
) STRICT;

CREATE TRIGGER diagnosis_made AFTER INSERT ON diagnosis BEGIN
  INSERT INTO job_change (diagnosis_id) VALUES (new.diagnosis_id);
END;
CREATE TRIGGER diagnosis_changed AFTER UPDATE OF state ON diagnosis BEGIN
  INSERT INTO job_change (diagnosis_id) VALUES (new.diagnosis_id);
END;
CREATE TRIGGER extension_accepted AFTER INSERT ON extension BEGIN
  INSERT INTO job_change (diagnosis_id) VALUES (new.diagnosis_id);
END;
CREATE TRIGGER extension_undone AFTER UPDATE OF undone_ns ON extension BEGIN
  INSERT INTO job_change (diagnosis_id) VALUES (new.diagnosis_id);
END;
CREATE TRIGGER improvement_made AFTER INSERT ON improvement BEGIN
  INSERT INTO job_change (improvement_id) VALUES (new.improvement_id);
END;
CREATE TRIGGER improvement_changed AFTER UPDATE OF state ON improvement BEGIN
  INSERT INTO job_change (improvement_id) VALUES (new.improvement_id);
END;
CREATE TRIGGER turn_made AFTER INSERT ON improvement_turn BEGIN
  INSERT INTO job_change (improvement_id) VALUES (new.improvement_id);
END;
CREATE TRIGGER turn_changed AFTER UPDATE ON improvement_turn BEGIN
  INSERT INTO job_change (improvement_id) VALUES (new.improvement_id);
END;
)sql";

}  // namespace driftwise::storage
