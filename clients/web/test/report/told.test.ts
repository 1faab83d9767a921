// Events of a story, against the names that the daemon writes into its record.
import { readdirSync, readFileSync } from 'node:fs';
import { expect, it } from 'vitest';
import { readReport } from '@/report/data';
import { storyOf, told } from '@/report/story';
import { sampleReport } from './sample';

const server = '../../server'; // from where the tests run
const families = 'stop|axes|run|queue|datum|load|motion|stabiliser|hold|data';

// Told by the other parts of a report, and why nothing is lost.
const elsewhere: Record<string, string> = {
  'run.created': 'its head says who started it', 'run.started': 'the run begins', 'run.closure': 'the closures', 'queue.added': 'the entry was queued',
  'queue.began': 'the entry begins', 'queue.done': 'the run of the entry is done', 'queue.followed': 'its results', 'data.suspect': 'the closure of its line',
  'data.imported': 'another data set', 'data.joined': 'another data set',
};

function sourcesIn(folder: string): string[] {
  return readdirSync(folder, { withFileTypes: true }).flatMap((one) => {
    const name = `${folder}/${one.name}`;
    return one.isDirectory() ? sourcesIn(name) : one.name.endsWith('.cc') ? [readFileSync(name, 'utf8')] : [];
  });
}
const found = (text: string, pattern: RegExp) => [...text.matchAll(pattern)].map((one) => one[1]);

it('tells all that the daemon records of the run, the queue and the axes', () => {
  const text = sourcesIn(`${server}/application`).join('\n');
  const names = [...found(text, new RegExp(`"((?:${families})\\.[a-z_]+)"`, 'g')), ...found(text, /\brecord(?:_own|_first)?\(\s*(?:\w+,\s*)?"([a-z_]+)"/g)];
  expect(names).toContain('stop');
  expect(names).toContain('axes.home');
  const alarms = found(readFileSync(`${server}/core/records/alarm_kinds.h`, 'utf8'), /"([a-z_]+\.[a-z_]+)"/g);
  expect([...new Set(names)].filter((name) => !(name in told) && !(name in elsewhere) && !alarms.includes(name))).toEqual([]);
});

it('tells a stop, the homing after it and the new zero, in order', () => {
  const at = (second: number) => `2026-11-20T17:00:0${second}Z`;
  const events = [
    { time: at(1), who: 'bob', what: 'stop', detail: 'bob stopped everything' }, { time: at(2), who: 'bob', what: 'axes.home', detail: 'bob references the axes' },
    { time: at(3), who: 'daemon', what: 'datum.opened', detail: 'datum 4: homed' }, { time: at(4), who: 'bob', what: 'lease.taken', detail: 'bob took the lease' },
  ];
  const story = storyOf(readReport(JSON.stringify({ ...sampleReport(), events }))).map((one) => one.what);
  expect(story).toEqual(['run 17 begins', 'bob stopped everything', 'bob references the axes', 'datum 4: homed', 'run 17 is done']);
});
