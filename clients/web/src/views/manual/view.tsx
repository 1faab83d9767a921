// Movements by hand: axes, hold to move, home; light and spots beside them. Set-points are changed at Instruments.
import './view.css';
import { ViewTitle } from '@/ui/view_title';
import { Axes } from './axes';
import { Light } from './light';

export default function Manual() {
  return (
    <>
      <ViewTitle sub="Axes by hand: hold a button to move; the axis stops when it is let go, and 300 ms after this page is gone">Manual</ViewTitle>
      <div class="stack">
        <Axes />
        <Light />
        <p class="muted">Set-points of the supports: <a href="/instruments">Instruments</a>. A cell at rest, thermometers side by side: <a href="/commissioning">Commissioning</a>.</p>
      </div>
    </>
  );
}
