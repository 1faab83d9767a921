#pragma once
// Power spectral density of evenly spaced values.
//
// Source: P. D. Welch, IEEE Trans. Audio Electroacoust. AU-15 (1967) 70: means of periodograms of
// overlapping segments.

#include <complex>
#include <span>
#include <vector>

namespace driftwise::stability {

struct SpectrumPoint {
  double frequency_hz = 0;
  double density = 0;  // one-sided: unit squared per Hz
};

// Hann window, segments that overlap by half, the mean of each taken off. Segments are the largest
// power of two with at least four of them in the values, at most 4096 long; fewer than 16 values:
// empty.
std::vector<SpectrumPoint> power_spectrum(std::span<const double> values, double interval_s);

// Discrete Fourier transform in place; the size is a power of two.
void transform(std::vector<std::complex<double>>& values);

}  // namespace driftwise::stability
