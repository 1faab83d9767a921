import { fixed, signed } from '@/format/numbers';
import { palette } from '@/plot/palette';
import { colourOf, type MapPicture } from './map_picture';

const steps = 24;

export function MapLegend({ picture }: { picture: MapPicture }) {
  const colours = palette();
  const reach = Math.max(Math.abs(picture.low), Math.abs(picture.high));
  const [from, to] = picture.kind === 'correction' ? [-reach, reach] : [picture.low, picture.high];
  const text = picture.kind === 'correction' ? signed : fixed;
  return (
    <div class="targets-scale note muted">
      <span>{text(from, reach < 10 ? 1 : 0)}</span>
      <svg width="180" height="12" aria-hidden="true">
        {Array.from({ length: steps }, (_, i) => (
          <rect key={i} x={(180 / steps) * i} width={180 / steps + 0.5} height="12" fill={colourOf(picture, from + ((to - from) * i) / (steps - 1), colours)} />
        ))}
      </svg>
      <span>{text(to, reach < 10 ? 1 : 0)} nm</span>
    </div>
  );
}
