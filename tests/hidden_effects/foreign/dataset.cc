#include "tests/hidden_effects/foreign/dataset.h"

#include <charconv>
#include <map>
#include <numbers>
#include <stdexcept>

namespace driftwise::foreign {
namespace {

std::string number(double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

const std::vector<std::string>& places_on_machines() {
  static const std::vector<std::string> names{
      "spindle_nose", "bed_left",    "bed_right",     "column_top", "column_foot", "motor2_housing",
      "frame",        "ballnut",     "scale_carrier", "laser_head", "table",       "plate_centre",
      "arm_upper",    "arm_lower",   "base",          "granite",    "pt100_3",     "ch07",
      "sensor_a",     "sensor_b",    "bearing",       "flange",     "beam_mid",    "cover",
      "oil",          "hexapod_leg4"};
  return names;
}

void dress_at_random(Dress& dress, Random& random, int thermometers) {
  static const std::vector<std::string> lengths{"m", "mm", "um", "nm"};
  static const std::vector<std::string> angles{"rad", "deg", "arcsec"};
  dress.motor_length = random.pick(lengths);
  dress.pose_length = random.pick(lengths);
  dress.motor_angle = random.pick(angles);
  dress.pose_angle = random.pick(angles);
  dress.temperature = random.chance(0.5) ? "degC" : "K";
  dress.pressure = random.chance(0.5) ? "hPa" : "Pa";
  dress.activity =
      random.pick(std::vector<std::string>{"spindle_1", "duty_pct", "heater_V", "load_pct"});
  std::vector<std::string> names = places_on_machines();
  for (int k = 0; k < thermometers; ++k) {
    const int at = random.below(static_cast<int>(names.size()));
    dress.thermometers.push_back(names[static_cast<std::size_t>(at)]);
    names.erase(names.begin() + at);
  }
}

struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> columns;

  void add(const std::string& name, int rows, const auto& value_of) {
    header.push_back(name);
    columns.emplace_back();
    for (int i = 0; i < rows; ++i) {
      columns.back().push_back(value_of(i));
    }
  }
};

std::string quoted(const std::string& text) { return "\"" + text + "\""; }

std::string list(const std::vector<std::string>& items) {
  std::string out = "[";
  for (std::size_t k = 0; k < items.size(); ++k) {
    out += (k > 0 ? "," : "") + items[k];
  }
  return out + "]";
}

std::string rms_json(const Campaign& campaign, const Eigen::VectorXd& rms) {
  std::vector<std::string> items;
  for (Eigen::Index j = 0; j < rms.size(); ++j) {
    items.push_back(
        number(rms[j] * (campaign.robot.pose_is_angle[static_cast<std::size_t>(j)] ? 1.0 : 1e6)));
  }
  return list(items);
}

std::string truth_json(const Truth& truth, const Dress& dress, bool listed) {
  std::vector<std::string> subjects;
  for (const std::string& subject : truth.subjects) {
    subjects.push_back(quoted(dress.symbol_of(subject)));
  }
  std::string parameters;
  for (const auto& [name, value] : truth.parameters) {
    parameters += (parameters.empty() ? "" : ",") + quoted(name) + ":" + number(value);
  }
  const auto rivals = [&](const std::vector<Rival>& from) {
    std::vector<std::string> items;
    for (const Rival& rival : from) {
      items.push_back("{\"cause\":" + quoted(rival.cause) +
                      ",\"subject\":" + quoted(dress.symbol_of(rival.subject)) +
                      ",\"gap\":" + number(rival.gap) + "}");
    }
    return list(items);
  };
  return "{\"cause\":" + quoted(truth.cause) +
         ",\"subject\":" + quoted(dress.symbol_of(truth.subject)) +
         ",\"subjects\":" + list(subjects) + ",\"parameters\":{" + parameters +
         "},\"chi2\":" + number(truth.chi2) +
         ",\"chi2_beyond_other\":" + number(truth.chi2_beyond_other) +
         (listed ? ",\"chi2_in_readings\":" + number(truth.chi2_in_readings) +
                       ",\"chi2_in_smoothed_readings\":" + number(truth.chi2_in_smoothed_readings)
                 : std::string()) +
         ",\"identifiable\":" + (truth.identifiable ? "true" : "false") +
         ",\"set\":" + rivals(truth.set) + ",\"nearest\":" + rivals(truth.nearest) + "}";
}

}  // namespace

std::string Dress::symbol_of(const std::string& study_symbol) const {
  if (study_symbol == "activity") {
    return activity.substr(0, activity.rfind('_'));
  }
  for (std::size_t k = 0; k < thermometers.size(); ++k) {
    if (thermometer_symbol(static_cast<int>(k)) == study_symbol) {
      return thermometers[k];
    }
  }
  return study_symbol;
}

double per_internal(const std::string& unit) {
  static const std::map<std::string, double> factors{{"m", 1e-3},
                                                     {"mm", 1.0},
                                                     {"um", 1e3},
                                                     {"nm", 1e6},
                                                     {"arcsec", 1.0},
                                                     {"deg", 1.0 / 3600.0},
                                                     {"rad", std::numbers::pi / (180.0 * 3600.0)}};
  const auto found = factors.find(unit);
  if (found == factors.end()) {
    throw std::runtime_error("unknown unit " + unit);
  }
  return found->second;
}

Dress dress_of(const Generated& made) {
  Dress dress;
  // Of the seeds that vary everything, half keep the study's names, so that a hole there shows.
  const bool half = Random(made.order.seed, "dress").chance(0.5);
  const bool vary = made.varied == "units" || (made.varied == "all" && half);
  dress.kind = made.order.units == "auto" ? (vary ? "random" : "study") : made.order.units;
  if (dress.kind == "random") {
    Random random(made.order.seed, "units");
    dress_at_random(dress, random, made.campaign.thermometer_count());
  } else if (dress.kind == "study") {
    for (int k = 0; k < made.campaign.thermometer_count(); ++k) {
      dress.thermometers.push_back(thermometer_symbol(k));
    }
  } else {
    throw std::runtime_error("units " + dress.kind + ": expected study, random or auto");
  }
  return dress;
}

std::string dataset_csv(const Generated& made, const Dress& dress) {
  const Campaign& campaign = made.campaign;
  const Robot& robot = campaign.robot;
  const int rows = campaign.rows();
  Table table;
  const auto integers = [&](const std::string& name, auto value_of) {
    table.add(name, rows, [&](int i) {
      return std::to_string(value_of(campaign.visits[static_cast<std::size_t>(i)]));
    });
  };
  const auto values = [&](const std::string& name, const Eigen::VectorXd& series) {
    table.add(name, rows, [&](int i) { return number(series[i]); });
  };
  if (campaign.has_times) {
    values("time_s", campaign.time_s);
  }
  if (campaign.has_runs) {
    integers("run", [](const Visit& visit) { return visit.run; });
    integers("datum", [](const Visit& visit) { return visit.datum; });
  }
  if (campaign.has_sets) {
    std::vector<bool> held_out(static_cast<std::size_t>(rows), false);
    for (const int i : campaign.validation) {
      held_out[static_cast<std::size_t>(i)] = true;
    }
    table.add("set", rows, [&](int i) {
      return held_out[static_cast<std::size_t>(i)] ? "validation" : "calibration";
    });
  }
  if (campaign.has_lines) {
    integers("line", [](const Visit& visit) { return visit.line; });
    integers("zero", [](const Visit& visit) { return visit.zero ? 1 : 0; });
  }
  if (campaign.has_dwell) {
    table.add("dwell_s", rows,
              [&](int i) { return number(campaign.visits[static_cast<std::size_t>(i)].dwell_s); });
  }
  for (int j = 0; j < robot.axes; ++j) {
    const std::string& unit =
        robot.motor_is_angle[static_cast<std::size_t>(j)] ? dress.motor_angle : dress.motor_length;
    const double factor = per_internal(unit);
    table.add("q" + std::to_string(j + 1) + "_" + unit, rows,
              [&](int i) { return number(factor * robot.motor_value(j, campaign.s(i, j))); });
  }
  for (int j = 0; j < robot.axes; ++j) {
    const std::string& unit =
        robot.pose_is_angle[static_cast<std::size_t>(j)] ? dress.pose_angle : dress.pose_length;
    values(robot.pose[static_cast<std::size_t>(j)] + "_" + unit,
           per_internal(unit) * made.pose.col(j));
  }
  if (campaign.has_tilts) {
    static const char* const kTilts[] = {"rx_", "ry_", "rz_"};
    for (int k = 0; k < 3; ++k) {
      values(kTilts[k] + dress.pose_angle, per_internal(dress.pose_angle) * made.tilt_read.col(k));
    }
  }
  if (campaign.has_force) {
    values("force_N", campaign.force_n);
  }
  const double kelvin = dress.temperature == "K" ? 273.15 : 0.0;
  for (int k = 0; k < campaign.thermometer_count(); ++k) {
    values(dress.thermometers[static_cast<std::size_t>(k)] + "_" + dress.temperature,
           made.read.col(k).array() + kelvin);
  }
  if (campaign.has_air) {
    values("air_" + dress.temperature, campaign.air_degc.array() + kelvin);
    values("pressure_" + dress.pressure,
           campaign.pressure_hpa * (dress.pressure == "Pa" ? 100.0 : 1.0));
    values("humidity_pct", campaign.humidity_pct);
  }
  if (campaign.has_activity) {
    values(dress.activity, campaign.activity);
  }

  std::string out = "# driftwise-dataset: 1\n# cell: foreign\n";
  for (int k = 0; k < campaign.thermometer_count(); ++k) {
    out += "# part." + dress.thermometers[static_cast<std::size_t>(k)] + ": " +
           campaign.thermometers[static_cast<std::size_t>(k)].part + "\n";
  }
  for (std::size_t k = 0; k < table.header.size(); ++k) {
    out += (k > 0 ? "," : "") + table.header[k];
  }
  for (int i = 0; i < rows; ++i) {
    out += '\n';
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
      out += (k > 0 ? "," : "") + table.columns[k][static_cast<std::size_t>(i)];
    }
  }
  return out + "\n";
}

std::string baseline_formula(const Generated& made, const Dress& dress) {
  const Campaign& campaign = made.campaign;
  const Robot& robot = campaign.robot;
  std::string out = robot.axes == 1 ? "q1 ~ " : "q ~ ";
  if (robot.axes == 1) {
    out += robot.pose[0];
    for (int power = 2; power <= campaign.degree; ++power) {
      out += " + " + robot.pose[0] + "^" + std::to_string(power);
    }
  } else {
    out += "poly(";
    for (const std::string& name : robot.pose) {
      out += name + ", ";
    }
    out += std::to_string(campaign.degree) + ")";
  }
  if (campaign.force_offered) {
    out += " + F";
  }
  if (static_cast<int>(campaign.offered.size()) == campaign.thermometer_count() &&
      !campaign.offered.empty()) {
    out += " + T";
  } else {
    for (const int k : campaign.offered) {
      out += " + " + dress.thermometers[static_cast<std::size_t>(k)];
    }
  }
  return out;
}

std::string key_json(const Generated& made, const Dress& dress, const std::string& file) {
  const Campaign& campaign = made.campaign;
  std::vector<std::string> truths;
  for (const Truth& truth : made.truths) {
    truths.push_back(truth_json(truth, dress, !made.planted.empty()));
  }
  std::vector<std::string> allowed;
  for (const std::string& cause : made.allowed) {
    allowed.push_back(quoted(cause));
  }
  std::vector<std::string> names;
  for (int k = 0; k < campaign.thermometer_count(); ++k) {
    names.push_back(quoted(dress.thermometers[static_cast<std::size_t>(k)]));
  }
  std::vector<std::string> poses;
  for (const std::string& name : campaign.robot.pose) {
    poses.push_back(quoted(name));
  }
  const double duration_s = campaign.time_s[campaign.rows() - 1];
  const double stroke = 2.0 * campaign.robot.half[0];
  const auto flag = [](bool value) { return value ? std::string("true") : std::string("false"); };
  return "{\"file\":" + quoted(file) + ",\"seed\":" + std::to_string(made.order.seed) +
         ",\"kind\":" + quoted(made.order.kind) + ",\"varied\":" + quoted(made.varied) +
         ",\"robot\":" + quoted(campaign.robot.kind) +
         ",\"axes\":" + std::to_string(campaign.robot.axes) + ",\"stroke\":" + number(stroke) +
         ",\"pose\":" + list(poses) + ",\"plan\":" + quoted(campaign.plan) +
         ",\"noise\":" + quoted(campaign.noise.kind) + ",\"noise_autocorrelation\":" +
         number(campaign.noise.autocorrelation(duration_s / campaign.rows())) +
         ",\"units\":" + quoted(dress.kind) + ",\"thermometers\":" + list(names) +
         ",\"activity\":" + quoted(dress.symbol_of("activity")) +
         ",\"times\":" + flag(campaign.has_times) + ",\"sets\":" + flag(campaign.has_sets) +
         ",\"rows\":" + std::to_string(campaign.rows()) +
         ",\"calibration_rows\":" + std::to_string(campaign.calibration.size()) +
         ",\"runs\":" + std::to_string(campaign.visits.back().run) +
         ",\"baseline\":" + quoted(baseline_formula(made, dress)) +
         ",\"chi2\":" + number(made.truths.empty() ? 0.0 : made.order.chi2) +
         ",\"hidden\":" + list(truths) + ",\"allowed\":" + list(allowed) +
         ",\"attempts\":" + std::to_string(made.attempts) + ",\"rms_validation_baseline\":" +
         rms_json(campaign, held_out_rms(campaign, made.read, made.error)) +
         ",\"rms_validation_truth_known\":" +
         rms_json(campaign, held_out_rms(campaign, made.read, made.error - made.effect)) + "}";
}

}  // namespace driftwise::foreign
