// Targets while another model begins to serve, or another zero is taken: nothing of the one before stands as the new one's.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { act, configure, fireEvent, render, screen } from '@testing-library/preact';
import { beforeEach, expect, test, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { EventSchema, CellService } from '@/api/gen/driftwise/v1/cell_service_pb';
import { ModelService } from '@/api/gen/driftwise/v1/model_service_pb';
import { MapTargetsResponseSchema, TargetService } from '@/api/gen/driftwise/v1/target_service_pb';
import { WatchEventSchema } from '@/api/gen/driftwise/v1/watch_service_pb';
import { go } from '@/app/router';
import { announce } from '@/live/events';
import Targets from '@/views/targets/view';
import { at } from '../fake/cell';
import { model, target } from '../fake/models';

vi.mock('@/plot/plot', () => ({ Plot: ({ spec }: { spec: { series: { y: number[] }[] } }) => <figure>{`hour of ${spec.series[0]?.y.map((y) => y.toFixed(0)).join(' ')}`}</figure> }));
vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

let serving = 12n;
let constantNm = 0; // of the datum
let mapped: Promise<void> | undefined; // until then maps get no answer
// Model 12 corrects by 100 nm everywhere, model 11 by 300 nm; in the hour before it was 10 nm less, or 20 nm, and 5 nm less yet of the later zero.
const correction = () => (serving === 12n ? 100 : 300) + constantNm;

beforeEach(() => {
  serving = 12n;
  constantNm = 0;
  mapped = undefined;
  HTMLCanvasElement.prototype.getContext = (() => null) as never;
  vi.stubGlobal('ResizeObserver', class { observe() {} disconnect() {} unobserve() {} });
  vi.stubGlobal('matchMedia', () => ({ matches: false, addEventListener() {}, addListener() {}, removeEventListener() {} }));
  useTransport(createRouterTransport(({ service }) => {
    service(CellService, { getStatus: () => ({ servingModelId: serving }) });
    service(ModelService, { getModel: ({ modelId }) => ({ model: model(Number(modelId)) }) });
    service(TargetService, {
      computeTarget: () => {
        const one = target(0.2);
        return { target: { ...one, modelId: serving, conditionsTime: at(0), coordinates: one.coordinates.map((q) => ({ ...q, correctionNm: correction() })) } };
      },
      listPastTargets: () => ({ modelId: serving, times: [at(-10)], tracks: ['q1', 'q2', 'q3'].map((q) => ({ channel: `${q}_mm`, correctionNm: [correction() - (serving === 12n ? 10 : 20) - constantNm / 10] })) }),
      mapTargets: async ({ horizontal, vertical }) => {
        await mapped;
        const each = (value: number) => Array.from({ length: horizontal!.count * vertical!.count }, () => value);
        return create(MapTargetsResponseSchema, {
          horizontal, vertical, modelId: serving, outside: each(0).map(() => false), unreachable: each(0).map(() => false),
          planes: ['q1', 'q2', 'q3'].map((q) => ({ channel: `${q}_mm`, correctionNm: each(correction()), u90Nm: each(40), positionMm: [] })),
        });
      },
      estimatePose: () => ({}),
    });
  }));
  go('/targets?x=0.2&y=0.2&z=0.9&force=0');
});

test('the map and the last hour are of the model that serves now', async () => {
  render(<Targets />);
  await screen.findByRole('img', { name: /from 100 to 100 nm/ });
  await screen.findByText('hour of -10 0');
  serving = 11n;
  act(() => announce(create(WatchEventSchema, { event: { case: 'model', value: { modelId: 11n, serving: true } } })));
  await screen.findByRole('img', { name: /from 300 to 300 nm/ });
  await screen.findByText('hour of -20 0');
});

test('the map and the last hour are of the zero that was taken last', async () => {
  render(<Targets />);
  await screen.findByRole('img', { name: /from 100 to 100 nm/ });
  await screen.findByText('hour of -10 0');
  constantNm = 50;
  act(() => announce(create(WatchEventSchema, { event: { case: 'record', value: create(EventSchema, { id: 900n, what: 'datum.opened' }) } })));
  await screen.findByRole('img', { name: /from 150 to 150 nm/ });
  await screen.findByText('hour of -15 0');
});

test('the map of another plane or pose is not shown, nor pressed, while that of the one wanted is on its way', async () => {
  render(<Targets />);
  for (const address of ['/targets?x=0.2&y=0.2&z=0.9&force=0&plane=x–z', '/targets?x=0.2&y=0.2&z=0.9&force=1&plane=x–z']) {
    await screen.findByRole('img', { name: /from 100 to 100 nm/ });
    let arrive!: () => void;
    mapped = new Promise((done) => (arrive = done));
    act(() => go(address));
    expect(screen.queryByRole('img', { name: /over the domain/ })).toBeNull();
    act(arrive);
  }
  const map = await screen.findByRole('img', { name: /from 100 to 100 nm/ });
  map.getBoundingClientRect = () => ({ left: 0, top: 0, width: 480, height: 346 }) as DOMRect;
  fireEvent.click(map, { clientX: 240, clientY: 170 });
  expect(new URLSearchParams(location.search).get('y')).toBe('0.2');
});
