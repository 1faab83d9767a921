#include "clients/cli/pages/model_page.h"

#include <cmath>
#include <optional>
#include <utility>

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/pages/accuracy_line.h"
#include "clients/cli/pages/budget_table.h"
#include "clients/cli/pages/configuration_text.h"
#include "server/identification/limits.h"

namespace driftwise::cli {
namespace {

std::string optional_text(bool present, double value, int decimals) {
  return present ? fixed(value, decimals) : "-";
}

std::string p_text(double p) {
  if (p < 1e-4) return "<1e-4";
  return fixed(p, 4);
}

void print_heading(const Console& console, const v1::GetModelResponse& shown) {
  const v1::Model& model = shown.model();
  const Paint paint = console.paint_out();
  const auto line = [&](const std::string& name, const std::string& value) {
    console.out << paint.dim(name + std::string(name.size() < 12 ? 12 - name.size() : 1, ' '))
                << value << '\n';
  };
  const auto& lineage = model.lineage();
  console.out << paint.bold("Model " + std::to_string(model.id()))
              << (model.name().empty() ? "" : "  " + model.name())
              << (model.serving() ? paint.good("  serving") : "") << '\n';
  if (shown.config_hash().empty())
    line("cell file", "none: not fitted from a run of this cell");
  else
    line("cell file", (shown.cell_name().empty() ? "" : shown.cell_name() + ", ") +
                          "measured under " + shown.config_hash());
  if (shown.configurations_size() > 1) {
    std::string earlier;
    for (int i = 0; i + 1 < shown.configurations_size(); ++i)
      earlier += (earlier.empty() ? "" : ", ") + shown.configurations(i).hash();
    line("", "and, for part of its data, under " + earlier);
  }
  if (!shown.config_hash().empty() && shown.config_hash() != shown.present_config_hash()) {
    line("", "in force now: " + shown.present_config_hash() +
                 (shown.changes_since().empty() ? ", the same by meaning" : ""));
    for (const auto& change : shown.changes_since())
      line("", "  " + change_text(change) + (change.asks() ? "" : " (recorded only)"));
  }
  for (const auto& mark : model.corrections()) {
    const auto texts = mark_texts(mark);
    line("rests on", mark.has_end_time() ? paint.bad(texts.front()) : texts.front());
    for (std::size_t i = 1; i < texts.size(); ++i) line("", texts[i]);
  }
  for (const auto& one : model.accuracy()) line("accuracy", "A90 " + accuracy_text(one));
  line(model.has_kinematics() ? "geometry" : "formula", model.formula());
  if (!model.has_kinematics())
    line("selection", model.select() == "all"
                          ? "every term kept"
                          : "stepwise, p to enter " + significant(model.p_enter(), 3) +
                                ", to remove " + significant(model.p_remove(), 3));
  line("data", lineage.source() + ": " + std::to_string(lineage.calibration_row_count()) +
                   " rows calibration, " + std::to_string(lineage.validation_row_count()) +
                   " validation, " + std::to_string(lineage.dropped_row_count()) + " dropped");
  if (lineage.excluded_row_count() > 0)
    line("excluded", std::to_string(lineage.excluded_row_count()) + " rows by hand, state " +
                         lineage.exclusions_hash());
  line("data hash", lineage.dataset_hash());
  line("model hash", model.hash());
  if (model.has_parent_model_id())
    line("parent", "model " + std::to_string(model.parent_model_id()));
  if (!lineage.run_ids().empty()) {
    std::string runs;
    for (const auto id : lineage.run_ids()) runs += (runs.empty() ? "" : ", ") + std::to_string(id);
    line("runs", runs);
  }
  line("fitted", clock_text(model.create_time()) + " UTC by " + model.created_by());
  if (!model.note().empty()) line("note", model.note());
}

// Numbers of a robot's geometry, as identified.
void print_kinematics(const Console& console, const v1::KinematicModel& kinematics) {
  const Paint paint = console.paint_out();
  if (!kinematics.parameters().empty()) {
    Table table({{"parameter"}, {"value", Align::right}, {"std. error", Align::right}, {""}});
    for (const auto& one : kinematics.parameters())
      table.add({one.name(), significant(one.value(), 9),
                 one.has_standard_error() ? significant(one.standard_error(), 3) : "held",
                 one.note()});
    console.out << '\n' << paint.bold("Geometry, identified") << '\n';
    table.print(console.out, paint);
  }
  console.out << '\n' << paint.bold("Robot file") << '\n' << kinematics.robot_toml();
}

void print_terms(const Console& console, const v1::ModelOutput& output) {
  const Paint paint = console.paint_out();
  const std::string summary = output.summary_unit();
  Table in({{"term"},
            {"coefficient", Align::right},
            {"unit"},
            {"std. error", Align::right},
            {"serial", Align::right},
            {"t", Align::right},
            {"p", Align::right},
            {"rms " + summary, Align::right},
            {"max " + summary, Align::right},
            {"VIF", Align::right}});
  Table out({{"left out"},
             {"coefficient", Align::right},
             {"std. error", Align::right},
             {"t", Align::right},
             {"p", Align::right},
             {"why"}});
  for (const auto& term : output.terms()) {
    if (term.included())
      in.add({term.term(), significant(term.coefficient(), 9), term.unit(),
              significant(term.standard_error(), 3),
              term.has_standard_error_serial() ? significant(term.standard_error_serial(), 3) : "-",
              significant(term.t(), 4), p_text(term.p()),
              optional_text(term.has_contribution_rms(), term.contribution_rms(), 1),
              optional_text(term.has_contribution_max(), term.contribution_max(), 1),
              optional_text(term.has_vif(), term.vif(), 1)});
    else
      out.add({term.term(), significant(term.coefficient(), 4),
               significant(term.standard_error(), 3), significant(term.t(), 3), p_text(term.p()),
               term.note()});
  }
  console.out << "coefficients in " << output.unit() << " per unit of the term, " << output.dof()
              << " degrees of freedom; standard errors classical, and serial: allowing for "
                 "rows that are not independent\n";
  in.print(console.out, paint);
  if (!out.empty()) {
    console.out << '\n';
    out.print(console.out, paint);
  }
}

void print_accuracy(const Console& console, const v1::ModelOutput& output) {
  const auto& a = output.accuracy();
  const std::string unit = " " + output.summary_unit();
  const auto line = [&](const char* rows, double mean, double u90, double a90) {
    console.out << "A90 " << fixed(a90, 2) << unit << " on " << rows << " (mean "
                << signed_fixed(mean, 2) << ", S90 " << fixed(u90, 2) << ")";
  };
  line("the calibration rows", a.mean_calibration(), a.u90_calibration(), a.a90_calibration());
  console.out << '\n';
  if (a.has_a90_validation()) {
    line("the validation rows", a.mean_validation(), a.u90_validation(), a.a90_validation());
    console.out << '\n';
    for (const auto& set : a.validation_sets()) {
      const auto& of_set = set.figures();
      const std::string rows = set.name() + ", " + std::to_string(of_set.row_count()) + " of them";
      line(rows.c_str(), of_set.mean(), of_set.u90(), of_set.a90());
      console.out << '\n';
    }
  }
  if (a.has_a90_blocks()) {
    line("held-out blocks of time", a.mean_blocks(), a.u90_blocks(), a.a90_blocks());
    if (a.has_a90_blocks_low() && a.has_a90_blocks_high())
      console.out << ", 90 % interval of A90 " << fixed(a.a90_blocks_low(), 2) << " to "
                  << fixed(a.a90_blocks_high(), 2);
    console.out << '\n';
  }
  console.out << "residual sd " << fixed(a.rmse(), 2) << unit << ", lag-1 autocorrelation "
              << fixed(a.lag1_autocorrelation(), 2) << ", worth "
              << fixed(a.effective_row_count(), 0) << " independent rows, condition index "
              << fixed(a.condition_index(), 1);
  if (a.has_pure_error())
    console.out << "\npure error of repeated poses " << fixed(a.pure_error(), 2) << unit;
  if (a.has_lack_of_fit_p())
    console.out << ", lack of fit F " << fixed(a.lack_of_fit_f(), 2) << ", p "
                << p_text(a.lack_of_fit_p());
  console.out << '\n';
  if (a.slow_share() > 0)
    console.out << "residuals: " << fixed(100 * a.slow_share(), 0)
                << " % of their variance is slow, over " << fixed(a.slow_row_count(), 1)
                << " rows\n";
}

// The target in whose variance the largest line that an instrument declares has the most share.
identification::TargetLimitFacts largest_declared(const v1::GetModelResponse& shown,
                                                  const std::string& channel) {
  constexpr double kNinety = 1.645;
  identification::TargetLimitFacts largest{.unit = "nm"};
  if (shown.config_hash().empty()) return largest;  // the instruments of its rows are not known
  for (const auto& budget : shown.budgets())
    for (const auto& coordinate : budget.coordinates()) {
      if (coordinate.channel() != channel) continue;
      for (const auto& line : coordinate.budget()) {
        const bool declared = line.source() >= v1::BudgetLine::SOURCE_LASER &&
                              line.source() <= v1::BudgetLine::SOURCE_MIRROR;
        const identification::TargetLimitFacts one{"nm", coordinate.u90_nm(),
                                                   budget_line_name(line), kNinety * line.u_nm()};
        const bool is_larger = one.instrument_u90 * largest.u90 > largest.instrument_u90 * one.u90;
        if (declared && one.u90 > 0 && (largest.u90 <= 0 || is_larger)) largest = one;
      }
    }
  return largest;
}

void print_limit(const Console& console, const v1::GetModelResponse& shown,
                 const v1::ModelOutput& output) {
  const auto& a = output.accuracy();
  const auto if_any = [](bool any, double value) {
    return any ? std::optional(value) : std::nullopt;
  };
  const identification::LimitFacts facts{
      .unit = output.summary_unit(),
      .a90_calibration = a.a90_calibration(),
      .a90_blocks = if_any(a.has_a90_blocks(), a.a90_blocks()),
      .a90_validation = if_any(a.has_a90_validation(), a.a90_validation()),
      .pure_error = if_any(a.has_pure_error(), a.pure_error()),
      .lack_of_fit_p = if_any(a.has_lack_of_fit_p(), a.lack_of_fit_p()),
      .slow_share = a.slow_share(),
      .slow_rows = a.slow_row_count()};
  console.out << "limited by " << identification::limited_by(facts).words << '\n';
  if (const auto target =
          identification::target_limited_by(largest_declared(shown, output.channel())))
    console.out << "its targets are limited by " << target->words << '\n';
}

// "selected: +x 812.31, +x^2 95.02, -t05 8.11": each step with the residual's spread after it.
void print_history(const Console& console, const v1::ModelOutput& output) {
  std::string text = "selected:";
  std::size_t width = text.size();
  for (const auto& step : output.history()) {
    if (step.action() == "start") continue;
    const std::string item = std::string(step.action() == "remove" ? " -" : " +") + step.term() +
                             " " + fixed(step.rmse(), 1);
    if (width + item.size() > 110) text += "\n         ", width = 9;
    text += item;
    width += item.size();
  }
  if (!output.history().empty())
    console.out << text << " (" << output.summary_unit() << " of residual after each step)\n";
}

void print_declared(const Console& console, const v1::GetModelResponse& shown) {
  if (shown.declared().empty()) return;
  console.out << '\n' << console.paint_out().bold("Instruments, as declared") << '\n';
  Table table({{"device"}, {"channel"}, {"standard uncertainty"}, {"", Align::right}});
  for (const auto& each : shown.declared())
    table.add({each.device_id(), each.channel(), each.name(), significant(each.value(), 4)});
  table.print(console.out, console.paint_out());
}

void print_budgets(const Console& console, const v1::GetModelResponse& shown) {
  for (const auto& budget : shown.budgets()) {
    std::string pose;
    for (const auto& value : budget.pose())
      pose += " " + value.channel() + " " + significant(value.value(), 4);
    console.out << '\n'
                << console.paint_out().bold("Uncertainty of a target, " + budget.place()) << ":"
                << pose << '\n';
    print_budget(console, budget.coordinates());
  }
}

// The model's accuracy in the line of the output that sets it; empty: another one does.
std::string heads(const v1::Model& model, const v1::ModelOutput& output) {
  for (const auto& one : model.accuracy())
    if (output.channel().starts_with(one.output() + "_")) return fixed(one.figures().a90(), 2);
  return "";
}

const v1::ModelOutput* output_of(const v1::Model& model, const std::string& channel) {
  for (const auto& output : model.outputs())
    if (output.channel() == channel) return &output;
  return nullptr;
}

}  // namespace

void print_model_page(const Console& console, const v1::GetModelResponse& shown) {
  const v1::Model& model = shown.model();
  const Paint paint = console.paint_out();
  print_heading(console, shown);
  print_declared(console, shown);
  if (model.has_kinematics()) print_kinematics(console, model.kinematics());
  for (const auto& output : model.outputs()) {
    console.out << '\n' << paint.bold(output.channel()) << ": ";
    if (!output.terms().empty()) print_terms(console, output);
    print_history(console, output);
    print_accuracy(console, output);
    print_limit(console, shown, output);
  }
  if (model.domain_size() > 0) {
    console.out << '\n' << paint.bold("Domain") << '\n';
    Table domain({{"channel"}, {"from", Align::right}, {"to", Align::right}});
    for (const auto& range : model.domain())
      domain.add({range.channel(), significant(range.min(), 8), significant(range.max(), 8)});
    domain.print(console.out, paint);
  }
  print_budgets(console, shown);
  console.out << '\n';
  for (const auto& warning : model.warnings())
    console.out << paint.warn("warning: ") << warning << '\n';
  console.out << "checked by ____________________  date ____________\n";
}

void print_models(const Console& console, const std::vector<v1::Model>& models) {
  if (models.empty()) {
    console.out << "no models yet: driftwise fit --run N --model \"q ~ x + x^2 + T\"\n";
    return;
  }
  Table table({{"model", Align::right},
               {"name"},
               {""},
               {"output"},
               {"A90", Align::right},
               {"val.", Align::right},
               {"mean", Align::right},
               {"blocks", Align::right},
               {"mean", Align::right},
               {"unit"},
               {"rows", Align::right},
               {"formula"},
               {"data"}});
  for (const auto& model : models) {
    bool first = true;
    for (const auto& output : model.outputs()) {
      const auto& a = output.accuracy();
      table.add({first ? std::to_string(model.id()) : "", first ? model.name() : "",
                 first && model.serving() ? "serving" : "", output.channel(), heads(model, output),
                 optional_text(a.has_a90_validation(), a.a90_validation(), 2),
                 a.has_mean_validation() ? signed_fixed(a.mean_validation(), 2) : "-",
                 optional_text(a.has_a90_blocks(), a.a90_blocks(), 2),
                 a.has_mean_blocks() ? signed_fixed(a.mean_blocks(), 2) : "-",
                 output.summary_unit(),
                 first ? std::to_string(model.lineage().calibration_row_count()) : "",
                 first ? model.formula() : "", first ? model.lineage().source() : ""});
      first = false;
    }
    // Imported: nothing was fitted, so there are no figures.
    if (model.outputs().empty() && model.has_kinematics())
      table.add({std::to_string(model.id()), model.name(), model.serving() ? "serving" : "", "-",
                 "-", "-", "-", "-", "-", "", "0", model.formula(), model.lineage().source()});
  }
  table.print(console.out, console.paint_out());
  for (const auto& model : models)
    if (!model.damage().empty())
      console.out << console.paint_out().bad("damaged  ") << model.damage() << '\n';
}

void print_comparison(const Console& console, const v1::CompareModelsResponse& comparison) {
  std::vector<Table::Column> columns = {{"output"}, {"term"}};
  for (const auto& model : comparison.models())
    columns.push_back(
        {"model " + std::to_string(model.id()) + (model.serving() ? "*" : ""), Align::right});
  Table table(columns);
  const auto figure = [&](const std::string& channel, const std::string& name, auto text_of) {
    std::vector<Table::Cell> row = {channel, name};
    for (const auto& model : comparison.models()) {
      const auto* output = output_of(model, channel);
      row.push_back(output == nullptr ? "-" : text_of(*output));
    }
    table.add(std::move(row));
  };
  std::vector<std::string> channels;
  for (const auto& row : comparison.rows())
    if (channels.empty() || channels.back() != row.channel()) channels.push_back(row.channel());
  for (const auto& channel : channels) {
    const auto judged = [](bool has, double a90, double mean, const std::string& unit) {
      return has ? fixed(a90, 2) + " " + unit + " (mean " + signed_fixed(mean, 2) + ")"
                 : std::string("-");
    };
    figure(channel, "A90 validation", [&](const v1::ModelOutput& o) {
      const auto& a = o.accuracy();
      return judged(a.has_a90_validation(), a.a90_validation(), a.mean_validation(),
                    o.summary_unit());
    });
    figure(channel, "A90 blocks", [&](const v1::ModelOutput& o) {
      const auto& a = o.accuracy();
      return judged(a.has_a90_blocks(), a.a90_blocks(), a.mean_blocks(), o.summary_unit());
    });
    figure(channel, "A90 calibration", [&](const v1::ModelOutput& o) {
      const auto& a = o.accuracy();
      return judged(true, a.a90_calibration(), a.mean_calibration(), o.summary_unit());
    });
    figure(channel, "terms in", [](const v1::ModelOutput& o) {
      int count = 0;
      for (const auto& term : o.terms()) count += term.included() ? 1 : 0;
      return std::to_string(count) + " of " + std::to_string(o.terms_size());
    });
    for (const auto& row : comparison.rows()) {
      if (row.channel() != channel) continue;
      std::vector<Table::Cell> cells = {channel, row.term()};
      for (const auto& cell : row.cells())
        cells.push_back(cell.included()  ? significant(cell.coefficient(), 6)
                        : cell.offered() ? "out"
                                         : "-");
      table.add(std::move(cells));
    }
  }
  table.print(console.out, console.paint_out());
  for (const auto& model : comparison.models())
    for (const auto& one : model.accuracy())
      console.out << "accuracy (A90) of model " << model.id() << ": " << accuracy_text(one) << '\n';
  console.out << "coefficients in the output's unit per unit of the term; out: offered, not taken; "
                 "-: not offered";
  for (const auto& model : comparison.models())
    if (model.serving()) console.out << "; *: serving";
  console.out << '\n';
}

}  // namespace driftwise::cli
