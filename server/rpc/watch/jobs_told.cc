#include "server/rpc/watch/jobs_told.h"

#include <algorithm>

namespace driftwise::rpc {
namespace {

bool is_running(const v1::DiagnosisProgress& job) {
  return job.state() == v1::Diagnosis::STATE_RUNNING;
}
bool is_running(const v1::ImprovementProgress& job) {
  return job.state() == v1::Improvement::STATE_RUNNING;
}

// Whether this says more than what was told; then it is what was told.
template <class Progress>
bool is_news(std::map<std::int64_t, Progress>& told, std::int64_t id, const Progress& now) {
  const auto before = told.find(id);
  if (before != told.end() && before->second.SerializeAsString() == now.SerializeAsString())
    return false;
  told[id] = now;
  return true;
}

}  // namespace

std::optional<v1::WatchEvent> JobsTold::from_cell(const v1::WatchEvent& event) {
  if (event.has_diagnosis() &&
      !is_news(diagnoses_, event.diagnosis().diagnosis_id(), event.diagnosis()))
    return std::nullopt;
  if (event.has_improvement() &&
      !is_news(improvements_, event.improvement().improvement_id(), event.improvement()))
    return std::nullopt;
  return event;
}

std::optional<v1::WatchEvent> JobsTold::from_record(v1::WatchEvent event) {
  if (event.has_diagnosis()) {
    auto& job = *event.mutable_diagnosis();
    const auto told = diagnoses_.find(job.diagnosis_id());
    if (is_running(job)) {
      if (told != diagnoses_.end()) return std::nullopt;
      diagnoses_.emplace(job.diagnosis_id(), job);
    } else if (told != diagnoses_.end()) {
      job.set_fraction(std::max(job.fraction(), told->second.fraction()));
      diagnoses_.erase(told);
    }
  }
  if (event.has_improvement()) {
    auto& job = *event.mutable_improvement();
    const auto told = improvements_.find(job.improvement_id());
    if (!is_running(job)) {
      if (told != improvements_.end()) improvements_.erase(told);
    } else if (told != improvements_.end()) {
      job = told->second;  // again, because a turn was stored
    } else {
      improvements_.emplace(job.improvement_id(), job);
    }
  }
  return event;
}

}  // namespace driftwise::rpc
