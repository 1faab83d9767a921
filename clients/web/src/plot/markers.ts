// Markers say what a point is by their shape: as path data for SVG, which a canvas draws too (Path2D).
import type { Marker } from './spec';

export interface MarkerShape {
  path: string; // about (0, 0), px
  filled: boolean;
}

const circle = (r: number) => `M${r} 0A${r} ${r} 0 1 1 ${-r} 0A${r} ${r} 0 1 1 ${r} 0Z`;

export const markerShapes: Record<Marker, MarkerShape> = {
  calibration: { path: circle(2.5), filled: true },
  validation: { path: 'M0 -4.2 4.2 0 0 4.2 -4.2 0Z', filled: false },
  zero: { path: 'M-3 0H3M0 -3V3', filled: false },
  rejected: { path: circle(3.4), filled: false },
  dot: { path: circle(1.8), filled: true },
};
