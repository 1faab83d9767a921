// The views before a daemon in memory: what a person reads, and that what was typed stays.
import { act, cleanup, fireEvent, render, screen, waitFor, within } from '@testing-library/preact';
import { beforeAll, beforeEach, describe, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import Diagnosis from '@/views/diagnosis/view';
import Models from '@/views/models/view';
import Targets from '@/views/targets/view';
import Trajectories from '@/views/trajectories/view';
import { ConfirmDialog } from '@/ui/confirm';
import { Promote } from '@/views/models/actions';
import { ConfigurationQuestion } from '@/parts/configuration';
import { Rests } from '@/parts/rests';
import { cell } from '@/live/state';
import { operatorName } from '@/app/session';
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { ModelService } from '@/api/gen/driftwise/v1/model_service_pb';
import { CorrectionMarkSchema } from '@/api/gen/driftwise/v1/provenance_pb';
import { GetStatusResponseSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { model } from '../fake/models';
import { fakeDaemon } from '../fake/daemon';

// What jsdom lacks.
beforeAll(() => {
  vi.stubGlobal('ResizeObserver', class { observe() {} disconnect() {} unobserve() {} });
  vi.stubGlobal('matchMedia', () => ({ matches: false, addEventListener() {}, addListener() {}, removeEventListener() {} }));
  HTMLCanvasElement.prototype.getContext = (() => null) as never;
});
vi.mock('@/plot/plot', () => ({ Plot: ({ spec }: { spec: { title: string } }) => <figure>{spec.title}</figure> }));

beforeEach(() => {
  sessionStorage.clear();
  useTransport(fakeDaemon());
  connection.value = { phase: 'live' };
});

const show = (address: string, View: () => preact.ComponentChild) => {
  go(address);
  return render(<View />);
};

describe('a diagnosis', () => {
  it('says verdict and gain first, then causes by rank with their intervals', async () => {
    show('/diagnosis/9', Diagnosis);
    await screen.findByText('Extended');
    const heading = document.querySelector('.accuracy-heading')!;
    expect(heading.textContent).toContain('of q1, validation rows');
    expect(heading.textContent).toContain('164 → 43 nm');
    expect(heading.textContent).toContain('mean +22 → −9, S90');
    expect(heading.textContent).toContain('160 → 40 nm');
    const first = screen.getByRole('heading', { name: /1\. The robot follows thermometer t07/ }).closest('section')!;
    expect(within(first).getByText('1740 to 1925 s')).toBeTruthy();
    expect(within(first).getByText('lag(t07, 1830 s)')).toBeTruthy();
    expect(screen.getByText(/These data do not tell it from/).textContent).toContain('creep');
    expect(screen.getByText('no tilt channel')).toBeTruthy();
    expect(await screen.findByText('Before: ±164 nm')).toBeTruthy();
  });
  it('shows the evidence on demand, with the likelihood of the parameter', async () => {
    show('/diagnosis/9', Diagnosis);
    fireEvent.click((await screen.findAllByRole('button', { name: 'Evidence' }))[0]);
    expect(await screen.findByText('Likelihood of tau')).toBeTruthy();
  });
  it('tells the loop turn by turn', async () => {
    show('/diagnosis/improve/2', Diagnosis);
    await screen.findByText('Turn 3');
    expect(screen.getByText('Nothing beyond noise is left')).toBeTruthy();
    expect(screen.getByText(/found that the robot follows t07/)).toBeTruthy();
  });
});

describe('what changes for others', () => {
  beforeAll(() => {
    HTMLDialogElement.prototype.showModal = function () { this.open = true; };
    HTMLDialogElement.prototype.close = function () { this.open = false; };
  });
  beforeEach(() => (operatorName.value = 'anna'));
  it('shows before accepting what changes, in nm, for which runs, earlier ones too', async () => {
    show('/diagnosis/9', () => <><Diagnosis /><ConfirmDialog /></>);
    fireEvent.click((await screen.findAllByRole('button', { name: /Accept as a model…/ }))[0]);
    expect(await screen.findByText(/run 17 \(campaign\): x by up to 3219 nm, rms 812 nm, 1\s?056 rows, from/)).toBeTruthy();
    expect(screen.getByText(/run 15 \(proof-geometry\): x by up to 240 nm/)).toBeTruthy();
    expect(screen.getByText(/earlier runs too/).textContent).toContain('every run that is measured later');
  });
  it('asks before a model with an open question serves', async () => {
    useTransport(createRouterTransport(({ service }) => service(ModelService, { getModel: () => ({ promotionQuestions: ['t01 is a thermometer of the instrument'] }) })));
    render(<><Promote model={model(11)} onDone={() => {}} /><ConfirmDialog /></>);
    fireEvent.click(screen.getByRole('button', { name: /Promote…/ }));
    expect(await screen.findByText('t01 is a thermometer of the instrument')).toBeTruthy();
    expect(await screen.findByRole('button', { name: 'Promote model 11 all the same' })).toBeTruthy();
    fireEvent.click(screen.getByText('Keep no model')); // the question belongs to the page: it would outlive the test
  });
  it('promotes over the questions that were read alone: one that came meanwhile is refused, and named when asked again', async () => {
    const questions = ['t01 is a thermometer of the instrument'];
    const promoteModel = vi.fn(() => ({}));
    useTransport(createRouterTransport(({ service }) => service(ModelService, { promoteModel, getModel: () => ({ promotionQuestions: questions }) })));
    render(<><Promote model={model(11)} onDone={() => {}} /><ConfirmDialog /></>);
    fireEvent.click(screen.getByRole('button', { name: /Promote…/ }));
    const verb = await screen.findByRole('button', { name: 'Promote model 11 all the same' });
    questions.push('correction 3 that it rests on was taken back');
    fireEvent.click(verb);
    expect(await screen.findByText(/model 11 was not promoted: correction 3 that it rests on was taken back/)).toBeTruthy();
    expect(promoteModel).not.toHaveBeenCalled();
    fireEvent.click(screen.getByRole('button', { name: /Promote…/ }));
    expect(await screen.findByText('correction 3 that it rests on was taken back', { selector: 'dd' })).toBeTruthy();
    fireEvent.click(await screen.findByRole('button', { name: 'Promote model 11 all the same' }));
    await vi.waitFor(() => expect(promoteModel).toHaveBeenCalledOnce());
  });
  it('promotes over the model that the question named alone', async () => {
    const promoteModel = vi.fn(({ servingModelId }: { servingModelId?: bigint }) => {
      if (servingModelId !== 12n) return {};
      throw new ConnectError('model 13 serves by now, where model 12 was seen to serve', Code.FailedPrecondition);
    });
    useTransport(createRouterTransport(({ service }) => service(ModelService, { promoteModel, getModel: () => ({}) })));
    const serves = (servingModelId?: bigint) => act(() => void (cell.value = create(GetStatusResponseSchema, { servingModelId })));
    serves(12n);
    render(<><Promote model={model(11)} onDone={() => {}} /><ConfirmDialog /></>);
    fireEvent.click(screen.getByRole('button', { name: /Promote…/ }));
    expect(await screen.findByText('Keep model 12')).toBeTruthy();
    serves(13n); // another person's promotion
    fireEvent.click(await screen.findByRole('button', { name: 'Promote model 11' }));
    expect(await screen.findByText(/model 13 serves by now/)).toBeTruthy();
    serves();
    fireEvent.click(screen.getByRole('button', { name: /Promote…/ }));
    fireEvent.click(await screen.findByRole('button', { name: 'Promote model 11' }));
    await vi.waitFor(() => expect(promoteModel.mock.calls.map(([asked]) => asked.servingModelId)).toEqual([12n, 0n])); // 0: none serves
    act(() => void (cell.value = undefined));
  });
  it('promotes a model that misses the wanted accuracy for a reason in writing only', async () => {
    const promoteModel = vi.fn(() => ({}));
    const missed = 'its campaign wants an A90 of 5 nm and it has 9.7 nm (q1)';
    useTransport(createRouterTransport(({ service }) => service(ModelService, { promoteModel, getModel: () => ({ promotionQuestions: [missed], questionsForAReason: [missed] }) })));
    render(<><Promote model={model(11)} onDone={() => {}} /><ConfirmDialog /></>);
    fireEvent.click(screen.getByRole('button', { name: /Promote…/ }));
    const verb = await screen.findByRole('button', { name: 'Promote model 11 all the same' });
    expect(verb.getAttribute('aria-disabled')).toBe('true');
    fireEvent.click(verb);
    expect(promoteModel).not.toHaveBeenCalled();
    fireEvent.input(screen.getByRole('textbox', { name: 'Why it serves all the same' }), { target: { value: ' a trial ' } });
    fireEvent.click(verb);
    await vi.waitFor(() => expect(promoteModel).toHaveBeenCalledWith(expect.objectContaining({ modelId: 11n, confirmed: true, reason: 'a trial' }), expect.anything()));
  });
  it('says when a model rests on a correction that was taken back', () => {
    render(<Rests what="fitted on data with" marks={[create(CorrectionMarkSchema, { correctionId: 3n, diagnosisId: 5n, acceptedBy: 'ben', endTime: { seconds: 1n }, endedBy: 'anna', changes: [{ channel: 'x_mm', runId: 17n, largestNm: 3219.4, rowCount: 200n }] })]} />);
    expect(screen.getByText('rests on a correction that was taken back')).toBeTruthy();
    expect(screen.getByText(/x of run 17 by up to 3219 nm in 200 rows/)).toBeTruthy();
  });
  it('shows what changed in the cell file while nobody has accepted it', async () => {
    cell.value = create(GetStatusResponseSchema, { attention: ['the cell file has changed since configuration aaaa: probe t07_degC: input 107 -> 108'] });
    render(<><ConfigurationQuestion /><ConfirmDialog /></>);
    expect(await screen.findByText('probe t07_degC: input 107 → 108')).toBeTruthy();
    expect(screen.queryByText(/listen/)).toBeNull();
    fireEvent.click(screen.getByRole('button', { name: 'Accept the change…' }));
    expect(await screen.findByText('Accept the changed cell file?')).toBeTruthy();
    cell.value = undefined;
  });
});

describe('models', () => {
  it('keeps a formula with a typo, says what is wrong and where, and does not offer to fit it to nothing', async () => {
    useTransport(fakeDaemon({ problem: (text) => (text.includes('to7') ? "formula: unknown channel 'to7', column 9" : '') }));
    show('/models', Models);
    const field = (await screen.findByRole('combobox', { name: 'Formula' })) as HTMLInputElement;
    fireEvent.input(field, { target: { value: 'q ~ x + to7' } });
    await screen.findByText(/unknown channel 'to7'/);
    expect(field.getAttribute('aria-invalid')).toBe('true');
    expect(field.value).toBe('q ~ x + to7');
    cleanup();
    render(<Models />); // a reload
    expect(((await screen.findByRole('combobox', { name: 'Formula' })) as HTMLInputElement).value).toBe('q ~ x + to7');
  });
  it('calls a formula that nobody has begun no mistake', async () => {
    useTransport(fakeDaemon({ problem: () => 'formula: found the end, expected a channel' }));
    show('/models', Models);
    const field = await screen.findByRole('combobox', { name: 'Formula' });
    await screen.findByText(/^For example q ~ x/);
    expect(field.getAttribute('aria-invalid')).toBeNull();
    fireEvent.input(field, { target: { value: 'q ~ x +' } });
    await screen.findByText(/found the end/);
    expect(field.getAttribute('aria-invalid')).toBe('true');
  });
  it('says why a button is off, once it is pressed', async () => {
    show('/models', Models);
    const compare = await screen.findByRole('button', { name: 'Compare the two marked' });
    const why = screen.getByText('Mark two models in the list first');
    expect(why.classList.contains('sr-only')).toBe(true);
    fireEvent.click(compare);
    await vi.waitFor(() => expect(why.classList.contains('sr-only')).toBe(false));
  });
  it('completes by keyboard alone', async () => {
    show('/models', Models);
    const field = (await screen.findByRole('combobox', { name: 'Formula' })) as HTMLInputElement;
    fireEvent.input(field, { target: { value: 'q ~ x' } });
    await screen.findByText(/rank 16 of 17/);
    field.value = 'q ~ x + la';
    field.setSelectionRange(10, 10);
    fireEvent.input(field);
    await waitFor(() => expect(field.getAttribute('aria-expanded')).toBe('true'));
    const list = within(screen.getByRole('listbox', { name: /what could follow/ }));
    expect(list.queryByRole('option', { selected: true })).toBeNull();
    fireEvent.keyDown(field, { key: 'ArrowDown' });
    expect(list.getByRole('option', { selected: true }).textContent).toContain('lag(t, tau s)');
    fireEvent.keyDown(field, { key: 'Enter' });
    expect(field.value).toBe('q ~ x + lag()');
  });
  it('shows terms with their contribution, residuals apart by set, and where the model comes from', async () => {
    show('/models/12', Models);
    const table = await screen.findByRole('region', { name: 'Table of the terms of q1' });
    expect(within(table).getByText('cannot be told apart from t08')).toBeTruthy();
    cleanup();
    show('/models/12?tab=lineage', Models);
    expect(await screen.findByText('model 11')).toBeTruthy();
  });
});

describe('a geometry as a model', () => {
  it('has no empty figures, and no C that would be refused', async () => {
    show('/models/30', Models);
    expect(await screen.findByText(/imported, no data judged it, 2026/)).toBeTruthy();
    expect(screen.getByRole('button', { name: 'Export JSON' })).toBeTruthy();
    expect(screen.queryByRole('button', { name: 'Export C' })).toBeNull();
    expect(document.querySelector('.models-heading')).toBeNull();
  });
});

describe('targets', () => {
  it('gives motor coordinates in groups of digits, with uncertainty and parts', async () => {
    show('/targets?x=0.2', Targets);
    expect(await screen.findByText(/^0\.199\s987\s31/)).toBeTruthy();
    expect(screen.getByText('inside the fitted domain, conditions fresh')).toBeTruthy();
    expect(within(screen.getByRole('region', { name: 'Parts of the correction' })).getByText('−220.4')).toBeTruthy();
  });
  it('puts what an instrument reads beside the pose by the model', async () => {
    show('/targets', Targets);
    const pose = within(await screen.findByRole('region', { name: 'Pose by the model and by the instruments' }));
    expect(pose.getByText('14.2 nm')).toBeTruthy();
    expect(pose.getByText('+20.0 nm')).toBeTruthy();
    expect(pose.getByText('beyond U')).toBeTruthy();
    expect(pose.queryByText('within U')).toBeNull();
  });
  it('works out where the end-effector is at the force that was typed where the cell reads none', async () => {
    useTransport(fakeDaemon({ noForce: true }));
    show('/targets?force=1.5', Targets);
    expect(await screen.findByText('at the force above, 1.5 N: the cell reads none')).toBeTruthy();
    expect(within(screen.getByRole('region', { name: 'Pose by the model and by the instruments' })).getByText('beyond U')).toBeTruthy();
    expect(screen.queryByText(/Run the model forward/)).toBeNull();
  });
  it('shows the numbers of a pose beyond the travel, marked, and offers no move there', async () => {
    show('/targets?x=801', Targets);
    expect(await screen.findByText(/not reachable: beyond the soft limits \(q1, q2, q3\)/)).toBeTruthy();
    expect(screen.getAllByText(/not reachable: limits/)).toHaveLength(3);
    expect(screen.queryByRole('button', { name: /Move there/ })).toBeNull();
  });
  it('keeps what is no number in its field and says what is expected', async () => {
    show('/targets', Targets);
    const field = (await screen.findByLabelText('x, mm')) as HTMLInputElement;
    fireEvent.input(field, { target: { value: '0.2x' } });
    expect(await screen.findByText('a number in mm is expected')).toBeTruthy();
    expect(field.value).toBe('0.2x');
  });
  it.each([['typed', '/targets?x=0.2', '0.2x'], ['in the address', '/targets?x=abc', undefined]])('shows no target and moves nowhere while a field is no number: %s', async (_, address, text) => {
    show(address, Targets);
    const field = (await screen.findByLabelText('x, mm')) as HTMLInputElement;
    if (text) fireEvent.input(field, { target: { value: text } });
    expect(await screen.findByText('no target: x is not read, a number in mm is expected')).toBeTruthy();
    expect(screen.queryByRole('button', { name: /Move there|Copy/ })).toBeNull();
    fireEvent.input(field, { target: { value: '0.2' } });
    expect(await screen.findByText(/^0\.199\s987\s31/)).toBeTruthy();
    expect(screen.getByRole('button', { name: /Move there/ })).toBeTruthy();
  });
  it('asks for the number that a decimal comma in the address means', async () => {
    show('/targets?x=0,2', Targets);
    expect(await screen.findByText(/^0\.199\s987\s31/)).toBeTruthy();
  });
  it('says why there are none and what to do', async () => {
    useTransport(fakeDaemon({ noModel: true }));
    show('/targets', Targets);
    expect(await screen.findByText(/No model serves/)).toBeTruthy();
    expect(screen.getByRole('link', { name: 'Promote a model' })).toBeTruthy();
    expect(screen.getByRole('link', { name: 'joint target' }).getAttribute('href')).toBe('/plans');
  });
});

describe('trajectories', () => {
  it('shows what a run would do, limits and what a fit could not tell apart', async () => {
    show('/trajectories/3', Trajectories);
    await screen.findByText('What a run of it would do');
    expect(screen.getByText(/206 calibration, 34 validation/)).toBeTruthy();
    expect(screen.getAllByText('−0.20 to 2.80 mm')).toHaveLength(3);
    expect(screen.getByText(/force rises with time/)).toBeTruthy();
    expect(screen.getByRole('slider')).toBeTruthy();
  });
  it('refuses an empty file before anything is sent, and keeps a text that is pasted', async () => {
    show('/trajectories', Trajectories);
    const input = (await screen.findByLabelText('a file, CSV')) as HTMLInputElement;
    fireEvent.change(input, { target: { files: [new File([], 'nothing.csv')] } });
    expect(await screen.findByText('nothing.csv is empty')).toBeTruthy();
    fireEvent.input(screen.getByLabelText(/trajectory, CSV/), { target: { value: 'q1_mm\n0\n' } });
    cleanup();
    render(<Trajectories />);
    expect(((await screen.findByLabelText(/trajectory, CSV/)) as HTMLTextAreaElement).value).toBe('q1_mm\n0\n');
  });
});
