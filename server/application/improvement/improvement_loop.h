#pragma once
// Step 5 back to step 1 of the published procedure, by itself. One turn:
//
//   measure (the first turn only), fit the first model; diagnose everything measured so far; extend
//   what is found and can be told apart; measure again on fresh points, and put what was promised
//   beside what was measured there.
//
// A set that cannot be told apart gets the separating measurement that the diagnosis proposes, once
// per set; where there is none, the set stays as it is and the reason says so. An extension whose
// gain the fresh points do not show is undone and ends the loop. One that they have not judged when
// the loop ends is undone too: nothing unproved stays in force, but for marks on readings (wrong
// rows, a sensor left out), which no fresh point can judge. What acts on its own runs only
// stays where fresh points are no worse. A finding that would be refused by itself (a term that no
// target can have, a correction that no instrument can need) is left out. It ends well when nothing
// beyond noise is left, when what is left is in no catalogue, after the last turn, or when the
// budget of time does not hold another measurement.
//
// Executor's thread. It moves the robot through Runs::create alone, under the lease of whoever
// began it, which it renews: a lease that is given up ends it at its next measurement.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/application/checks/model_checks.h"
#include "server/application/diagnoses/diagnoses.h"
#include "server/application/diagnoses/extension_plan.h"
#include "server/application/diagnoses/extensions.h"
#include "server/application/improvement/improvements.h"
#include "server/application/manual/manual_control.h"
#include "server/application/models/models.h"
#include "server/application/models/promotions.h"
#include "server/application/plumbing/signal.h"
#include "server/application/runs/runs.h"
#include "server/application/serving/serving.h"
#include "server/application/trajectories/trajectories.h"
#include "server/core/ports/clock.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

// What the loop works with; all of them outlive it.
struct ImprovementServices {
  Trajectories& trajectories;
  ManualControl& manual;
  Runs& runs;
  Models& models;
  ModelChecks& checks;
  Promotions& promotions;
  Diagnoses& diagnoses;
  Extensions& extensions;
  const Serving& serving;
};

class ImprovementLoop {
 public:
  struct Hooks {
    std::function<void(int turn, const std::string& step)> tell;
    std::function<Awaitable<Result<void>>(ImprovementTurn)> keep;  // stores a turn, again and again
  };
  ImprovementLoop(asio::any_io_executor executor, ImprovementServices services, Clock& clock,
                  Caller caller, ImproveRequest request, ImprovementId id, Hooks hooks);

  // Result: why it ended well. Errors: of the step that failed; cancelled STOPPED after stop().
  Awaitable<Result<std::string>> carry_out();
  // Ends it at the next step; a run or a diagnosis of its own that is under way ends too, unless
  // the daemon ends (leave_run): then the run goes on with the next start.
  Awaitable<void> stop(bool leave_run);
  // Undoes what this turn accepted and no fresh points have judged. Result: what became of it, half
  // a sentence, also when it was undone before; empty: nothing was accepted, or it is judged.
  Awaitable<std::string> withdraw();

 private:
  enum class After { next_turn, end };
  Awaitable<Result<RunRecord>> measure(std::string what, std::string trajectory_text);
  Awaitable<Result<void>> begin();
  Awaitable<void> end_own_jobs();
  Awaitable<std::string> undo_unproved(ExtensionRecord extension);
  Awaitable<Result<After>> take_turn();
  void renew_lease();
  CellTime next_renewal() const;
  Awaitable<Result<DiagnosisView>> diagnose();
  Awaitable<Result<DiagnosisView>> separate(DiagnosisView view);
  Awaitable<Result<After>> extend(const DiagnosisView& view, std::vector<int> findings);
  Awaitable<std::vector<int>> acceptable(const DiagnosisView& view, std::vector<int> findings);
  Awaitable<Result<After>> keep_unjudged(const ExtensionRecord& extension);
  Awaitable<Result<After>> measure_again(ExtensionRecord extension, Reach reach);
  Awaitable<Result<ModelCheck>> errors_on(ModelId model, RunId run,
                                          std::optional<CorrectionId> leaving_out);
  Awaitable<void> promote_proven();
  Awaitable<Result<void>> keep();
  void say(const std::string& sentence);
  bool has_time_for(double seconds) const;
  Result<void> check() const;
  std::string text_of_repeat(int repeat) const;

  ImprovementServices services_;
  Clock& clock_;
  Caller caller_;
  ImproveRequest request_;
  ImprovementId id_;
  Hooks hooks_;
  Trajectory plan_;
  double estimated_s_ = 0;  // of one measurement
  CellTime began_;
  bool stopping_ = false, leave_run_ = false;
  Signal wake_;                           // whatever is waited for
  std::optional<RunId> run_;              // of its own, under way
  std::optional<DiagnosisId> diagnosis_;  // likewise
  std::optional<ExtensionRecord> unproved_;
  bool withdrawing_ = false;
  std::string withdrawn_;
  std::vector<RunId> runs_;
  std::optional<ModelId> model_;
  std::string formula_;
  int repeats_ = 0;
  ImprovementTurn turn_;
  std::string reason_;
};

}  // namespace driftwise::application
