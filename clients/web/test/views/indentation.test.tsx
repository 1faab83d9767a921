// The view Indentation before a daemon in memory: stages, contacts, corrections, table of indents, verdict.
import { render, screen, within } from '@testing-library/preact';
import { beforeEach, describe, expect, it } from 'vitest';
import { useTransport } from '@/api/client';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import { cellTimeMs } from '@/live/state';
import { answerInWords, answers, recordFrom, tableFrom } from '@/views/indentation/record';
import Indentation from '@/views/indentation/view';
import { at, startMs } from '../fake/cell';
import { fakeDaemon } from '../fake/daemon';
import { indentationRecord } from '../fake/indentation';

beforeEach(() => {
  sessionStorage.clear();
  connection.value = { phase: 'live' };
  go('/indentation');
});

describe('an indentation', () => {
  it('shows its stages, contacts and corrections', { timeout: 30_000 }, async () => {
    useTransport(fakeDaemon());
    render(<Indentation />);
    const contacts = within(await screen.findByRole('table', { name: 'Contacts on the substrate' }, { timeout: 10_000 }));
    expect(contacts.getAllByRole('row')).toHaveLength(1 + 17);
    expect(contacts.getByText('indent x1000')).toBeTruthy();
    const rounds = within(screen.getByRole('table', { name: 'Rounds of the alignment' }));
    expect(rounds.getByText('accepted')).toBeTruthy();
    expect(rounds.getAllByText('−540.2')).toHaveLength(2);
    expect(within(screen.getByRole('table', { name: 'Stages' })).getAllByText('done')).toHaveLength(4);
    expect(screen.getByText(/plan 1: mn by model 5, ma by model 2 \(coarse\): contacts 1, 2, 3/)).toBeTruthy();
  });
  it('shows the table of indents with uncertainties, what cannot be told apart, and the verdict', { timeout: 30_000 }, async () => {
    useTransport(fakeDaemon());
    render(<Indentation />);
    const table = within(await screen.findByRole('table', { name: 'Indents against what was wanted' }, { timeout: 10_000 }));
    expect(table.getByText('102.96')).toBeTruthy(); // table 8.1 of the study, first indent
    expect(screen.getByText(/Cannot be told apart by these indents: tool lever, microscope scale/)).toBeTruthy();
    expect(screen.getAllByText('wanted accuracy not reached').length).toBeGreaterThan(0);
  });
  it('says that a client which is silent in contact may be lost, and what to do', async () => {
    useTransport(fakeDaemon({ lostAt: 3 }));
    cellTimeMs.value = Number(at(3).seconds) * 1000 + 30 * 60_000;
    render(<Indentation />);
    expect(await screen.findByText(/No report for 30 min: the client may be lost/)).toBeTruthy();
    expect(screen.getByText('In contact at the last report.')).toBeTruthy();
    expect(screen.getByText('the client was lost during the contact')).toBeTruthy();
    expect(screen.getByText('align under way')).toBeTruthy();
    cellTimeMs.value = startMs;
  });
  it('reads no document of another version', () => {
    expect(recordFrom('{"driftwise_indentation":2}')).toBeUndefined();
    expect(recordFrom('{"stage":')).toBeUndefined();
    expect(tableFrom('{"driftwise_indents":1,"indents":[]}')).toBeTruthy();
    expect(recordFrom('{"driftwise_indentation":1}')?.contact_list).toEqual([]);
  });
  it('says in words which models answered and what speaks against the answer', () => {
    expect(answerInWords('plan 1, mn=5, ma=fine:2 OUTSIDE_DOMAIN(t19_degC) ZERO_OUTSIDE_DOMAIN(t19_degC) OUTSIDE_DOMAIN(t09_degC t19_degC) COARSE(ma)')).toEqual({
      who: 'plan 1: mn by model 5, ma by model 2 (fine)',
      doubts: ['outside what the model was fitted on (t19, t09)', 'the zero of the present datum was taken outside what the model was fitted on (t19)', 'by the coarse model of a robot (ma)'],
    });
    expect(answerInWords('plan 1, mn=5, ma=blend:2+1').who).toBe('plan 1: mn by model 5, ma by models 2 and 1 (blend)');
    expect(answerInWords('geometry, raw motor coordinates: a trial')).toEqual({ who: 'geometry, raw motor coordinates: a trial', doubts: [] });
    expect(answerInWords('')).toEqual({ who: '', doubts: [] });
  });
  it('lists what answered with the contacts that it moved to', () => {
    expect(answers(indentationRecord().contact_list)).toEqual([{ by: 'plan 1, mn=5, ma=coarse:2', contacts: Array.from({ length: 17 }, (_, i) => i + 1).join(', ') }]);
  });
});
