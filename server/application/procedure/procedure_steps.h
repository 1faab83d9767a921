#pragma once
// The study's procedure (its chapter 3): steps 0 to 5 with a state that is computed from what is on
// record, what is missing, and the command that does it. Pure.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/records/wanted_accuracy.h"

namespace driftwise::application {

struct ProcedureSource {    // a kind of source of inaccuracy
  std::string name{};       // "air"
  std::string measured_by;  // "air1_degC, pressure_hPa"; empty: nothing measures it
};

struct ProcedureFigure {
  std::string coordinate{}, unit{};  // "x", "nm"
  std::optional<double> a90{}, wanted{};
};

struct ProcedureFacts {
  std::vector<ProcedureSource> sources{};
  struct Run {
    std::int64_t id = 0;
    std::string setup{};
    bool done = false, compensated = false;
    std::int64_t points = 0;
    bool joined = false;  // made of others of these
  };
  std::vector<Run> runs{};                 // newest first
  std::optional<std::int64_t> campaign{};  // the newest run that states a wanted accuracy ...
  std::vector<WantedAccuracy> wanted{};    // ... and what it states
  std::vector<std::string> unreadable{};   // what it states badly, sentences
  struct Judged {
    std::string output{}, unit{};
    double a90 = 0;
  };
  struct Model {
    std::int64_t id = 0;
    bool serving = false;
    std::int64_t validation_rows = 0;
    std::vector<Judged> accuracy{};  // every output
    std::string largest_line{};      // of its budget: "beam offset"; empty: none
    double largest_u_nm = 0;
    bool largest_is_measured = false;  // a line of the fit, not of an instrument
    double combined_u_nm = 0;          // of all lines of the budget
    std::string doubt{};               // measurements that disagree with it; empty: none
  };
  std::optional<Model> model{};                // the one that serves, else the newest
  std::optional<std::int64_t> verified_run{};  // the newest compensated run that is done
  std::vector<Judged> verified{};              // per pose coordinate, of that run
  std::string not_verified{};                  // why that run cannot be judged; empty: it can
};

struct ProcedureStep {
  enum class State : std::uint8_t { done, open, not_reached };
  int number = 0;
  std::string name{};
  State state = State::open;
  std::string found{};    // what the record says
  std::string missing{};  // what is missing; empty: nothing
  std::string command{};  // that does it; empty: nothing to do
  std::vector<ProcedureSource> sources{};
  std::vector<ProcedureFigure> figures{};
  std::optional<int> back_to{};  // the wanted accuracy is not reached
  std::string largest_line{};
  std::optional<double> largest_u_nm{};
};

std::vector<ProcedureStep> procedure_steps(const ProcedureFacts& facts);

}  // namespace driftwise::application
