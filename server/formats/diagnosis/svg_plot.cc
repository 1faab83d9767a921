#include "server/formats/diagnosis/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "server/formats/diagnosis/html_text.h"

namespace driftwise::formats {
namespace {

constexpr double kLeft = 64, kRight = 14, kTop = 10, kBottom = 28;

std::string svg_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  std::string shown = text;
  if (shown.ends_with(".0")) shown.resize(shown.size() - 2);
  return shown;
}

// As many decimals as the step between ticks has.
std::string tick_text(double value, const std::vector<double>& ticks) {
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
  const int decimals = static_cast<int>(-std::floor(std::log10(step) + 1e-9));
  return std::abs(value) < 1e-9 * step ? "0" : fixed_text(value, decimals);
}

class PlotFrame {
 public:
  explicit PlotFrame(const PlotSpec& spec) : spec_(spec) {}
  double x(double value) const {
    return kLeft + (value - spec_.x.low) / (spec_.x.high - spec_.x.low) * inner_width();
  }
  double y(double value) const {
    const double share = (value - spec_.y.low) / (spec_.y.high - spec_.y.low);
    return kTop + (1 - std::clamp(share, 0.0, 1.0)) * inner_height();
  }
  double inner_width() const { return spec_.width - kLeft - kRight; }
  double inner_height() const { return spec_.height - kTop - kBottom; }
  bool shows(double at) const { return at >= spec_.x.low && at <= spec_.x.high; }

  std::string rectangle(const std::string& css, PlotRange across, PlotRange up) const {
    const double left = x(std::clamp(across.low, spec_.x.low, spec_.x.high));
    const double right = x(std::clamp(across.high, spec_.x.low, spec_.x.high));
    return "<rect class=\"" + css + "\" x=\"" + svg_number(left) + "\" y=\"" +
           svg_number(y(up.high)) + "\" width=\"" + svg_number(std::max(1.0, right - left)) +
           "\" height=\"" + svg_number(y(up.low) - y(up.high)) + "\"/>";
  }
  std::string line(const std::string& css, double x0, double y0, double x1, double y1) const {
    return "<path class=\"" + css + "\" d=\"M" + svg_number(x0) + " " + svg_number(y0) + "L" +
           svg_number(x1) + " " + svg_number(y1) + "\"/>";
  }
  std::string axes() const;

 private:
  const PlotSpec& spec_;
};

std::string PlotFrame::axes() const {
  std::string out;
  const double bottom = spec_.height - kBottom, right = spec_.width - kRight;
  const auto up = plot_ticks(spec_.y, 5), across = plot_ticks(spec_.x, 7);
  for (const double tick : up) {
    out += line("grid", kLeft, y(tick), right, y(tick));
    out += "<text class=\"tick end\" x=\"" + svg_number(kLeft - 8) + "\" y=\"" +
           svg_number(y(tick) + 4) + "\">" + tick_text(tick, up) + "</text>";
  }
  for (const double tick : across) {
    out += line("grid", x(tick), kTop, x(tick), bottom);
    out += "<text class=\"tick middle\" x=\"" + svg_number(x(tick)) + "\" y=\"" +
           svg_number(bottom + 18) + "\">" + tick_text(tick, across) + "</text>";
  }
  if (spec_.zero_line && spec_.y.low <= 0 && spec_.y.high >= 0)
    out += line("zero", kLeft, y(0), right, y(0));
  return out;
}

// Points as strokes without length and with round caps: one path, a few bytes each.
std::string points_path(const PlotFrame& frame, const PlotSeries& series) {
  std::string d;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) continue;
    const double x = frame.x(series.x[i]), y = frame.y(series.y[i]);
    if (series.mark == PlotSeries::Mark::diamonds)
      d += "M" + svg_number(x - 3) + " " + svg_number(y) + "l3-3 3 3-3 3z";
    else
      d += "M" + svg_number(x) + " " + svg_number(y) + "h0";
  }
  return d;
}

std::string line_path(const PlotFrame& frame, const PlotSeries& series) {
  std::string d;
  bool open = false;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) {
      open = false;
      continue;
    }
    d += (open ? "L" : "M") + svg_number(frame.x(series.x[i])) + " " +
         svg_number(frame.y(series.y[i]));
    open = true;
  }
  return d;
}

// Per pixel the span from the least to the largest.
std::string span_path(const PlotFrame& frame, const PlotSeries& series) {
  const auto pixels = static_cast<std::size_t>(frame.inner_width()) + 1;
  std::vector<double> low(pixels, std::numeric_limits<double>::infinity());
  std::vector<double> high(pixels, -std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) continue;
    const double at = std::floor(frame.x(series.x[i]) - kLeft);
    if (at < 0 || at >= static_cast<double>(pixels)) continue;
    auto& least = low[static_cast<std::size_t>(at)];
    auto& most = high[static_cast<std::size_t>(at)];
    least = std::min(least, series.y[i]);
    most = std::max(most, series.y[i]);
  }
  std::string d;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (low[i] > high[i]) continue;
    d += "M" + svg_number(kLeft + static_cast<double>(i) + 0.5) + " " +
         svg_number(frame.y(low[i]) + 1) + "V" + svg_number(frame.y(high[i]) - 1);
  }
  return d;
}

std::string drawn(const PlotFrame& frame, const PlotSeries& series) {
  if (series.mark == PlotSeries::Mark::line)
    return "<path class=\"curve " + series.css + "\" d=\"" + line_path(frame, series) + "\"/>";
  if (series.x.size() > kPlotPoints)
    return "<path class=\"span " + series.css + "\" d=\"" + span_path(frame, series) + "\"/>";
  const char* kind = series.mark == PlotSeries::Mark::diamonds ? "diamonds " : "points ";
  return "<path class=\"" + std::string(kind) + series.css + "\" d=\"" +
         points_path(frame, series) + "\"/>";
}

}  // namespace

std::vector<double> plot_ticks(PlotRange range, int count) {
  const double length = range.high - range.low;
  if (!(length > 0) || !std::isfinite(length)) return {};
  const double rough = length / std::max(1, count);
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10 * decade;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= rough) {
      step = factor * decade;
      break;
    }
  }
  std::vector<double> ticks;
  for (double k = std::ceil(range.low / step); k * step <= range.high + 1e-9 * step; ++k)
    ticks.push_back(k * step);
  return ticks;
}

PlotRange plot_range(const std::vector<const std::vector<double>*>& values, double widen,
                     bool symmetric) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto* list : values) {
    for (const double value : *list) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (low > high) return {};
  if (symmetric) high = std::max(std::abs(low), std::abs(high)), low = -high;
  const double margin = high > low ? widen * (high - low) : std::max(1.0, std::abs(high));
  return {low - margin, high + margin};
}

std::string svg_plot(const PlotSpec& spec) {
  const PlotFrame frame(spec);
  std::string out = "<svg role=\"img\" aria-label=\"" + html_escaped(spec.title) +
                    "\" viewBox=\"0 0 " + std::to_string(spec.width) + " " +
                    std::to_string(spec.height) + "\"><desc>" + html_escaped(spec.description) +
                    "</desc>";
  if (spec.band)
    out += frame.rectangle(
        "band", spec.x,
        {std::max(spec.band->low, spec.y.low), std::min(spec.band->high, spec.y.high)});
  if (spec.x_band) out += frame.rectangle("band", *spec.x_band, spec.y);
  out += frame.axes();
  for (const double at : spec.x_marks)
    if (frame.shows(at))
      out += frame.line("mark", frame.x(at), kTop, frame.x(at), spec.height - kBottom);
  for (const auto& series : spec.series) out += drawn(frame, series);
  return out + "</svg>";
}

}  // namespace driftwise::formats
