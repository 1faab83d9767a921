#pragma once
// The study's procedure (its chapter 3) as a page: steps 0 to 5 with a state that is computed from
// what is on record, what is missing, and the command that does it. Pure.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace driftwise::cli {

// "wanted_a90_nm", "wanted_a90_arcsec": metadata of a run. The wanted accuracy of its campaign.
inline constexpr const char* kWantedPrefix = "wanted_a90_";

struct ProcedureFacts {
  // Kinds of sources of inaccuracy, and whether a device or section of the cell measures them.
  std::vector<std::pair<std::string, bool>> sources{};
  struct Run {
    std::int64_t id = 0;
    std::string setup{};
    bool done = false, compensated = false;
    std::int64_t points = 0;
  };
  std::vector<Run> runs{};                 // newest first
  std::optional<std::int64_t> campaign{};  // the newest run that states a wanted accuracy ...
  struct Wanted {
    std::string unit{};  // "nm"
    double a90 = 0;
  };
  std::vector<Wanted> wanted{};  // ... and what it states
  struct Judged {
    std::string output{}, unit{};
    double a90 = 0;
  };
  struct Model {
    std::int64_t id = 0;
    bool serving = false;
    std::int64_t validation_rows = 0;
    std::vector<Judged> accuracy{};
    std::string largest_line{};        // of its budget, "beam offset 12.3 nm"; empty: none
    bool largest_is_measured = false;  // a line of the fit, not of an instrument
  };
  std::optional<Model> model{};                // the one that serves, else the newest
  std::optional<std::int64_t> verified_run{};  // the newest compensated run that is done
  std::vector<Judged> verified{};              // per pose coordinate, of that run
};

struct ProcedureStep {
  int number = 0;
  std::string name{};
  std::string state{};    // "done", "open", "not reached"
  std::string found{};    // what the record says
  std::string missing{};  // what is missing; empty: nothing
  std::string command{};  // that does it; empty: nothing to do
};

std::vector<ProcedureStep> procedure_steps(const ProcedureFacts& facts);

}  // namespace driftwise::cli
