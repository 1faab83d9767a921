#pragma once
// Models or serving plans in service, oldest first, that no rollback has taken back: the last one
// serves. Made of the history of promotions and rollbacks, oldest first.

#include <optional>
#include <vector>

namespace driftwise {

template <class Id>
class ServedInOrder {
 public:
  // One that serves already is not in service twice, though earlier versions recorded it again.
  void promoted(Id id) {
    if (ids_.empty() || ids_.back() != id) ids_.push_back(id);
  }
  // now: the one in service after the rollback; none: nothing serves. Records of earlier versions
  // have rollbacks from a repeated promotion to the same one: they take nothing back.
  void rolled_back(std::optional<Id> now) {
    while (!ids_.empty() && ids_.back() != now) ids_.pop_back();
    if (now && ids_.empty()) ids_.push_back(*now);
  }
  const std::vector<Id>& ids() const { return ids_; }
  // The one that a rollback puts back; none: nothing served before.
  std::optional<Id> before() const {
    return ids_.size() > 1 ? std::optional(ids_[ids_.size() - 2]) : std::nullopt;
  }

 private:
  std::vector<Id> ids_;
};

}  // namespace driftwise
