// States, verdicts and places as words and marks.
import { Diagnosis_State, Verdict as V, type Diagnosis, type OutputDiscrepancy } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { fixed, significant } from '@/format/numbers';
import type { VerdictKind } from '@/ui/verdict';
import { withCauses } from './causes';

export interface Judgement {
  kind: VerdictKind;
  word: string;
  sentence: string;
}

export function judgementOf(diagnosis: Diagnosis): Judgement {
  if (diagnosis.state === Diagnosis_State.RUNNING) return { kind: 'idle', word: 'Looking', sentence: 'The data are being looked at.' };
  if (diagnosis.state === Diagnosis_State.CANCELLED) return { kind: 'idle', word: 'Cancelled', sentence: diagnosis.reason || 'It was ended before it had found anything.' };
  if (diagnosis.state === Diagnosis_State.FAILED) return { kind: 'bad', word: 'Failed', sentence: diagnosis.reason };
  const found = diagnosis.findings.length;
  const causes = `${found} ${found === 1 ? 'cause' : 'causes'}`;
  switch (diagnosis.verdict) {
    case V.ADEQUATE:
      return { kind: 'good', word: 'Adequate', sentence: 'Nothing beyond noise is supported by these data.' };
    case V.EXTENDED:
      return { kind: 'extended', word: 'Extended', sentence: `${causes} found; nothing further remains beyond noise.` };
    case V.UNEXPLAINED: {
      const goes = diagnosis.leftOver.map((one) => one.goesWith).join(', ');
      return { kind: 'warn', word: 'Unexplained', sentence: `${found ? `${causes} found, but structure` : 'Structure'} remains that no known cause explains${goes ? `; it goes with ${goes}` : ''}.` };
    }
    default:
      return { kind: 'idle', word: 'Not judged', sentence: '' };
  }
}

// "run 3, robot ma": the data that were looked at.
export const dataText = (diagnosis: Diagnosis): string =>
  (diagnosis.runIds.length ? `${diagnosis.runIds.length === 1 ? 'run' : 'runs'} ${diagnosis.runIds.join(', ')}` : 'a file') + (diagnosis.robot && `, robot ${diagnosis.robot}`);

export const outputOf = (diagnosis: Diagnosis, symbol: string | undefined): OutputDiscrepancy | undefined =>
  diagnosis.outputs.find((one) => one.output === symbol) ?? diagnosis.outputs.find((one) => one.output === diagnosis.accuracy[0]?.output) ?? worst(diagnosis.outputs);

// The one with the largest error after the findings: it heads the page.
function worst(outputs: readonly OutputDiscrepancy[]): OutputDiscrepancy | undefined {
  return [...outputs].sort((a, b) => after(b) - after(a) || b.a90 - a.a90)[0];
}

export const before = (one: OutputDiscrepancy): number => one.a90ValidationBefore ?? one.a90CalibrationBefore;
export const after = (one: OutputDiscrepancy): number => one.a90ValidationAfter ?? one.a90CalibrationAfter;

const units: readonly [RegExp, string][] = [
  [/_?nm_per_k_per_h$/, 'nm/(K/h)'], [/_?nm_per_n_per_mm$/, 'nm/(N mm)'], [/_?nm_per_mm$/, 'nm/mm'], [/_?nm_per_k$/, 'nm/K'], [/_?nm_per_n$/, 'nm/N'],
  [/_?nm_per_h$/, 'nm/h'], [/_?ppm_per_k$/, 'ppm/K'], [/_?ppm_per_h$/, 'ppm/h'], [/_?nm_per_hpa$/, 'nm/hPa'], [/_?ppm_per_hpa$/, 'ppm/hPa'], [/_?nm_per_pct$/, 'nm/%'], [/_?ppm_per_pct$/, 'ppm/%'], [/_?arcsec_per_k_per_h$/, 'arcsec/(K/h)'], [/_?arcsec_per_k$/, 'arcsec/K'], [/_?arcsec_per_n$/, 'arcsec/N'], [/_?arcsec_per_h$/, 'arcsec/h'],
  [/_?urad_per_m$/, 'urad/m'], [/_?urad_per_newton_m$/, 'urad/(N m)'], [/_s$/, 's'], [/_nm$/, 'nm'], [/_mm$/, 'mm'], [/_arcsec$/, 'arcsec'], [/_h$/, 'h'], [/_mK$/, 'mK'],
];

// As the daemon writes rates that stand for several coordinates: "ppm_per_k_x_q1".
const rates: readonly [string, string][] = [
  ['nm_per_k_per_h_', 'nm/(K/h)'], ['nm_per_n_per_mm_', 'nm/(N mm)'], ['nm_per_mm_', 'nm/mm'], ['nm_per_k_', 'nm/K'], ['nm_per_n_', 'nm/N'], ['nm_per_h_', 'nm/h'], ['ppm_per_k_', 'ppm/K'], ['ppm_per_h_', 'ppm/h'], ['nm_per_hpa_', 'nm/hPa'], ['ppm_per_hpa_', 'ppm/hPa'], ['nm_per_pct_', 'nm/%'], ['ppm_per_pct_', 'ppm/%'],
  ['arcsec_per_k_per_h_', 'arcsec/(K/h)'], ['arcsec_per_k_', 'arcsec/K'], ['arcsec_per_n_', 'arcsec/N'], ['arcsec_per_h_', 'arcsec/h'],
];

// "tau_s" -> name "tau", unit "s"; "offset_mm_rx_q1" -> name "offset rx, q1", unit "mm".
export function parameterWords(name: string): { name: string; unit: string } {
  const words = (text: string) => (text || 'size').replace(/^((?:[A-Za-z\d]+\.)?q\d)$/, 'size, $1').replace(/_((?:[A-Za-z\d]+\.)?q\d)$/, ', $1').replaceAll('_', ' ');
  for (const [pattern, unit] of units)
    if (pattern.test(name)) return { name: words(name.replace(pattern, '')), unit };
  for (const [begin, unit] of rates)
    if (name.startsWith(begin)) return { name: words(name.slice(begin.length)), unit };
  const within = /^(.+)_(mm|nm|arcsec)_(.+)$/.exec(name);
  return within ? { name: words(`${within[1]}_${within[3]}`), unit: within[2] } : { name: words(name), unit: '' };
}

// The daemon's sentence ends in all figures; the page has them in a table below.
// A formula has commas and numbers of its own.
export const headline = (sentence: string): string => (sentence.includes('~') ? sentence : sentence.split(/, (?:[A-Za-z][\w.]* ){0,3}-?\d[^,;]*(?=[,;.(]|$)|; [\w.]+: /)[0]).replace(/\.$/, '');

// Of what is counted: rows, the degree of a polynomial, the number of a harmonic.
export const isWhole = (name: string): boolean => ['count', 'degree', 'harmonic'].includes(name);

// No more digits than the interval supports: two of its width.
export function parameterText(value: number, interval: { low: number; high: number } | undefined, whole = false): string {
  if (whole) return fixed(value);
  const width = interval ? interval.high - interval.low : 0;
  if (!(width > 0)) return significant(value, 3);
  return fixed(value, Math.min(9, Math.max(0, 1 - Math.floor(Math.log10(width)))));
}

// A channel at the beginning (q1, x) keeps its letter.
export const sentenceCase = (text: string): string => (/^[a-z]{2,}([\s,:]|$)/.test(text) ? text[0].toUpperCase() + text.slice(1) : text);

// Sentences of a turn, without what stands in its table; those that differ in one name only are one.
export function turnLines(what: string): string[] {
  const lines = what.split(/\.+ (?=[A-Z]|stopped|[a-z]+\d* (?:has|is|sags|turns|heats) |\w+_\w+ \w+ cannot)/).map(headline).filter((line) => line !== '' && line !== 'A90 on fresh points').map((line) => sentenceCase(withCauses(line)));
  const terms = /^The geometry needs terms in (\S+) that the simulation lacks$/;
  const needed = lines.flatMap((line) => terms.exec(line)?.[1] ?? []);
  if (needed.length < 2) return lines;
  const first = lines.findIndex((line) => terms.test(line));
  return lines.flatMap((line, at) => (at === first ? [`The geometry needs terms in ${needed.slice(0, -1).join(', ')} and ${needed.at(-1)} that the simulation lacks`] : terms.test(line) ? [] : [line]));
}

export const appliesWords: Record<string, string> = {
  robot: 'extends simulation and served model',
  correction: 'corrects an instrument; the served model stays',
  dataset: 'keeps rows or a sensor out',
};
