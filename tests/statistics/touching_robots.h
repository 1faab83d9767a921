#pragma once
// The two robots' plant and the decisions of server/indentation, without wire and daemon: for
// counts that need thousands of approaches. Motor coordinates come from nominal geometry (raw
// coordinates: no model serves here).

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/simulated/plant/two_robots/two_robots_plant.h"
#include "server/indentation/procedure.h"

namespace driftwise::statistics {

class TouchingRobots final : public indentation::TouchingCell {
 public:
  // Referenced, upper robot at rest, warm. warm_h: hours simulated before.
  explicit TouchingRobots(std::uint64_t seed, std::vector<std::string> overrides = {},
                          double warm_h = 2);

  // TouchingCell. Nothing fails here.
  Result<Answer> move_above(double x_mm, double y_mm, double z_mm) override;
  Result<Answer> move_below(double rx_arcsec, double ry_arcsec, double z_mm) override;
  Result<Answer> retract_below(double rx_arcsec, double ry_arcsec, double z_mm) override;
  Result<void> nudge_above(double dx_mm, double dy_mm) override;
  Result<Eigen::MatrixXd> look() override;
  Result<void> wait(double cell_s) override;
  Result<Here> here() override;  // by the interferometers and autocollimators

  void pass(double seconds);

  // Approaches at the present place and tilts until the decision; somebody knocks before a window.
  struct Knock {
    int before_window = -1;  // -1: nobody does
    double amplitude_nm = 0;
  };
  indentation::Approach::Next approach(const indentation::ApproachRule& rule, Knock knock);

  // Moves of the last approach() from the first after which tip and surface would overlap, both at
  // rest where they were told to be, to the decision; 0: they never did.
  int moves_in_contact() const { return static_cast<int>(overlap_nm_.size()); }
  // After each of them: how far the surface is above where the tip would be without contact.
  const std::vector<double>& overlap_nm() const { return overlap_nm_; }

  simulated::TwoRobotsPlant& plant() { return *plant_; }
  double time_s() const { return time_s_; }

 private:
  simulated::TimeNs now() const;
  void settle(int first, int count);
  void go_below(double rx_arcsec, double ry_arcsec, double z_mm, bool only_down);

  std::unique_ptr<simulated::TwoRobotsPlant> plant_;
  double time_s_ = 0;
  std::vector<double> overlap_nm_{};
  double rx_arcsec_ = 0, ry_arcsec_ = 0;
  std::array<double, 3> above_mm_{}, below_mm_{};  // told to the two robots
};

// The study's: 250 nm steps, three touches 2 mm apart, contacts within 500 nm.
indentation::ProcedureRules study_rules();

struct Aligned {
  bool accepted = false;
  indentation::ProcedureRecord record{};
  std::string trouble{};
  double drawn_rx_arcsec = 0, drawn_ry_arcsec = 0;  // of the substrate on the lower robot
  // At the truth: how much the gaps between tip and substrate differ at the touched places. The
  // surface is aligned to the frame of the robot above, whose own planes are not those of the base.
  double left_nm = 0;
};
// Alignment and common zero of the procedure.
Aligned align(TouchingRobots& robots);

struct FalseContacts {
  int approaches = 0, steps = 0, knocks = 0;
  int contacts = 0, aborts = 0, looked_again = 0;
  double room_change_k = 0, hours = 0;
};
// approaches of 40 steps far below the tip, from fresh places, in a room that drifts, with one
// knock of 100 to 800 nm in each.
FalseContacts count_false_contacts(std::uint64_t seed, int approaches);

struct FoundContacts {
  int approaches = 0, contacts = 0;
  std::array<int, 4> moves{};  // how many were found at the first move that touches, the second ...
  int before = 0, later = 0;   // with no force between them; beyond the fourth
  double largest_force_mn = 0;
  std::vector<std::vector<double>> late_overlap_nm{};  // of those beyond the second, per move
};
// approaches from some 20 um below the surface, at fresh places of an untilted substrate.
FoundContacts count_contacts(std::uint64_t seed, int approaches);

}  // namespace driftwise::statistics
