// The parts of the view: what was fitted, and the two studies that ask which method and which thermometers.
import { place, segments } from '@/app/router';

const sections = [
  { path: '/models', title: 'Fitted models' },
  { path: '/models/methods', title: 'Methods side by side' },
  { path: '/models/sensors', title: 'Which thermometers suffice' },
];

export function Sections() {
  const here = `/${segments.value.join('/')}`;
  const run = place.value.query.get('run');
  return (
    <nav class="tabs" aria-label="Parts of the view Models">
      {sections.map(({ path, title }) => (
        <a key={path} href={path + (run ? `?run=${run}` : '')} aria-current={path === here ? 'page' : undefined}>{title}</a>
      ))}
    </nav>
  );
}
