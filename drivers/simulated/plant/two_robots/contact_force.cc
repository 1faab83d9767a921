#include "drivers/simulated/plant/two_robots/contact_force.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driftwise::simulated {
namespace {

constexpr double kNewtonPerGpaNm2 = 1e-9;  // 1 GPa = 1e-9 N/nm^2
constexpr double kPerMm = 1e-6;            // of N/mm: N/nm
constexpr int kHalvings = 60;

double loading_n(double depth_nm, const ContactParameters& c) {
  const double area_nm2 =
      24.5 * depth_nm * depth_nm + 2 * std::numbers::pi * c.tip_radius_nm * depth_nm;
  return c.hardness_gpa * kNewtonPerGpaNm2 * area_nm2;
}

double substrate_n(double depth_nm, const ContactParameters& c, const Crater& crater) {
  if (depth_nm <= 0) return 0;
  if (depth_nm >= crater.depth_nm) return loading_n(depth_nm, c);
  const double elastic_nm = std::max(1.0, c.recovery * crater.depth_nm);
  return crater.force_n * std::max(0.0, 1 - (crater.depth_nm - depth_nm) / elastic_nm);
}

}  // namespace

double diagonal_um(const Crater& crater) {
  const double per_depth = 2 * std::numbers::sqrt2 * std::tan(68 * std::numbers::pi / 180);
  return per_depth * crater.depth_nm * 1e-3;
}

double HoldingServo::resisting_n(double push_nm) const {
  const double beyond_nm = std::max(0.0, std::abs(push_nm) - p_.dead_zone_nm);
  return integral_n_ +
         kPerMm * (p_.flexure_n_mm * push_nm + p_.servo_n_mm * std::copysign(beyond_nm, push_nm));
}

double HoldingServo::push_nm(double force_n) const {
  const double left_n = force_n - integral_n_;
  const double flexure = kPerMm * p_.flexure_n_mm, servo = kPerMm * p_.servo_n_mm;
  const double within_nm = left_n / flexure;
  if (std::abs(within_nm) <= p_.dead_zone_nm) return within_nm;
  const double beyond_nm = (std::abs(left_n) - flexure * p_.dead_zone_nm) / (flexure + servo);
  return std::copysign(p_.dead_zone_nm + beyond_nm, left_n);
}

void HoldingServo::integrate(double push_nm, double step_s) {
  const double error_nm =
      std::copysign(std::max(0.0, std::abs(push_nm) - p_.integral_zone_nm), push_nm);
  integral_n_ = std::clamp(integral_n_ + kPerMm * p_.integral_n_mm_s * error_nm * step_s,
                           -p_.integral_limit_n, p_.integral_limit_n);
}

// The depth at which substrate and servo push alike; both grow with what each is given.
Balance balance(double overlap_nm, const ContactParameters& contact, const HoldingServo& servo,
                Crater& crater) {
  const double free_nm = servo.push_nm(0);
  if (overlap_nm <= free_nm) return {.push_nm = free_nm, .force_n = 0};
  double low_nm = 0, high_nm = overlap_nm - free_nm;
  for (int i = 0; i < kHalvings; ++i) {
    const double depth_nm = (low_nm + high_nm) / 2;
    if (substrate_n(depth_nm, contact, crater) < servo.resisting_n(overlap_nm - depth_nm))
      low_nm = depth_nm;
    else
      high_nm = depth_nm;
  }
  const double force_n = substrate_n(high_nm, contact, crater);
  if (high_nm > crater.depth_nm) {
    crater.depth_nm = high_nm;
    crater.force_n = force_n;
  }
  return {.push_nm = servo.push_nm(force_n), .force_n = force_n};
}

}  // namespace driftwise::simulated
