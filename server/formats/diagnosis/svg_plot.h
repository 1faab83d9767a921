#pragma once
// Small plots as SVG text, for pages without script. Colours come from the page's style sheet by
// class, so that light and dark are the page's business; nothing in the text is an inline style,
// which a strict content security policy would refuse.

#include <optional>
#include <string>
#include <vector>

namespace driftwise::formats {

struct PlotRange {
  double low = 0, high = 1;
};

struct PlotSeries {
  enum class Mark { points, diamonds, line };
  Mark mark = Mark::points;
  std::string css;               // "q1", "q2", "q3", "muted", ..: a colour of the page
  std::vector<double> x{}, y{};  // what is not finite is a gap
};

struct PlotSpec {
  std::string title;        // what a person who cannot see it hears
  std::string description;  // range and trend, for the same person
  int width = 560, height = 250;
  PlotRange x, y;
  std::vector<PlotSeries> series{};
  std::optional<PlotRange> band{};    // of y, behind the data
  std::optional<PlotRange> x_band{};  // of x, behind the data: an interval
  std::vector<double> x_marks{};      // upright lines: an instant, a best value
  bool zero_line = false;
};

// More than this many points in a series are drawn as the span from the least to the largest per
// pixel, which looks like the points.
inline constexpr std::size_t kPlotPoints = 2500;

std::string svg_plot(const PlotSpec& spec);

// About `count` round numbers inside the range: 1, 2 or 5 times a power of ten apart.
std::vector<double> plot_ticks(PlotRange range, int count);

// The finite ones' range, widened by a share; symmetric about 0 when asked. 0 .. 1 for none.
PlotRange plot_range(const std::vector<const std::vector<double>*>& values, double widen = 0.05,
                     bool symmetric = false);

}  // namespace driftwise::formats
