// The views. Each is one folder under views/ whose view.tsx exports the component as default; it is fetched when
// first shown. `key` is what follows g on the keyboard.
import type { ComponentType } from 'preact';

export interface ViewEntry {
  name: string; // first segment of its address
  title: string; // in the bar, and its h1 unless the view sets another
  key: string;
  load: () => Promise<{ default: ComponentType }>;
}

export const views: readonly ViewEntry[] = [
  { name: 'now', title: 'Now', key: 'n', load: () => import('@/views/now/view') },
  { name: 'instruments', title: 'Instruments', key: 'i', load: () => import('@/views/instruments/view') },
  { name: 'manual', title: 'Manual', key: 'h', load: () => import('@/views/manual/view') },
  { name: 'commissioning', title: 'Commissioning', key: 'c', load: () => import('@/views/commissioning/view') },
  { name: 'trajectories', title: 'Trajectories', key: 't', load: () => import('@/views/trajectories/view') },
  { name: 'runs', title: 'Runs', key: 'r', load: () => import('@/views/runs/view') },
  { name: 'queue', title: 'Queue', key: 'q', load: () => import('@/views/queue/view') },
  { name: 'models', title: 'Models', key: 'm', load: () => import('@/views/models/view') },
  { name: 'plans', title: 'Plans', key: 'p', load: () => import('@/views/plans/view') },
  { name: 'indentation', title: 'Indentation', key: 'o', load: () => import('@/views/indentation/view') },
  { name: 'procedure', title: 'Procedure', key: 's', load: () => import('@/views/procedure/view') },
  { name: 'diagnosis', title: 'Diagnosis', key: 'd', load: () => import('@/views/diagnosis/view') },
  { name: 'targets', title: 'Targets', key: 'a', load: () => import('@/views/targets/view') },
  { name: 'lookback', title: 'Look back', key: 'b', load: () => import('@/views/lookback/view') },
  { name: 'record', title: 'Record', key: 'e', load: () => import('@/views/record/view') },
];
